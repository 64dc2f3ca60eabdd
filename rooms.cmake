# A room is a target that can include only the headers of the rooms that it uses. The top folder of
# the project is on no include path: each room has its own include folder in the build tree,
# rooms/NAME, with links to its headers. So "engine/control/tuning.h" is found under its full name,
# but only by targets that link `control`.
#
#   room(NAME [PLACES place...] [USES room...] [OPENS library...] [PUBLIC_LIBRARIES target...]
#        [LIBRARIES target...] [DEFINES definition...] [EXCEPT pattern...])
#
# A place is a folder or a header, by its path from the top folder. A room's sources are all .cpp
# files below its folders but those that match an EXCEPT pattern. OPENS names the libraries below
# that the room itself includes. Headers of PUBLIC_LIBRARIES are also visible to users of the room.
# What each room is, uses and opens is written to rooms.txt in the build tree: NAME | place... |
# room... | library...
file(WRITE ${PROJECT_BINARY_DIR}/rooms.txt "")

# closed_library(NAME TARGET HEADER...): a library that a room can include only if it OPENS it. As
# external headers are in /usr/include, which every compiler searches, headers of the same names with
# an #error directive precede these in other rooms.
function(closed_library name target)
    set_property(GLOBAL APPEND PROPERTY closed_libraries ${name})
    set_property(GLOBAL PROPERTY target_of_${name} ${target})
    set_property(GLOBAL PROPERTY headers_of_${name} ${ARGN})
endfunction()

function(room name)
    cmake_parse_arguments(ROOM "" ""
        "PLACES;USES;OPENS;PUBLIC_LIBRARIES;LIBRARIES;DEFINES;EXCEPT" ${ARGN})
    list(JOIN ROOM_PLACES " " places)
    list(JOIN ROOM_USES " " uses)
    list(JOIN ROOM_OPENS " " opens)
    file(APPEND ${PROJECT_BINARY_DIR}/rooms.txt "${name} | ${places} | ${uses} | ${opens}\n")
    set(headers ${PROJECT_BINARY_DIR}/rooms/${name})
    file(REMOVE_RECURSE ${headers}) # links only
    foreach(place IN LISTS ROOM_PLACES)
        cmake_path(GET place PARENT_PATH above)
        file(MAKE_DIRECTORY ${headers}/${above})
        file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${place} ${headers}/${place} SYMBOLIC)
    endforeach()

    list(TRANSFORM ROOM_PLACES PREPEND ${PROJECT_SOURCE_DIR}/ OUTPUT_VARIABLE folders)
    list(TRANSFORM folders APPEND /*.cpp)
    # By their path from the top folder, so that no pattern matches where the project stands.
    file(GLOB_RECURSE sources RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS ${folders})
    foreach(pattern IN LISTS ROOM_EXCEPT)
        list(FILTER sources EXCLUDE REGEX ${pattern})
    endforeach()

    if(NOT sources)
        add_library(${name} INTERFACE)
        target_include_directories(${name} INTERFACE ${headers})
        target_link_libraries(${name} INTERFACE ${ROOM_PUBLIC_LIBRARIES} ${ROOM_USES})
        return()
    endif()
    add_library(${name} STATIC ${sources})
    target_include_directories(${name} PUBLIC ${headers})
    target_compile_definitions(${name} PRIVATE ${ROOM_DEFINES})
    target_link_libraries(${name} PUBLIC ${ROOM_PUBLIC_LIBRARIES} ${ROOM_USES}
                                  PRIVATE ${ROOM_LIBRARIES})
    target_precompile_headers(${name} REUSE_FROM precompiled)
    set(closed ${PROJECT_BINARY_DIR}/rooms/closed/${name})
    file(REMOVE_RECURSE ${closed})
    get_property(libraries GLOBAL PROPERTY closed_libraries)
    foreach(library IN LISTS libraries)
        get_property(target GLOBAL PROPERTY target_of_${library})
        get_property(library_headers GLOBAL PROPERTY headers_of_${library})
        if(library IN_LIST ROOM_OPENS)
            target_link_libraries(${name} PRIVATE ${target})
        else()
            foreach(header IN LISTS library_headers)
                file(WRITE ${closed}/${header} "#error \"closed to this room: ${library}\"\n")
            endforeach()
        endif()
    endforeach()
    target_include_directories(${name} PRIVATE ${closed})
endfunction()

find_package(PkgConfig REQUIRED)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
pkg_check_modules(LIBUSB REQUIRED IMPORTED_TARGET libusb-1.0)
pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio)
pkg_check_modules(MD REQUIRED IMPORTED_TARGET libmd)
pkg_check_modules(PORTAUDIO REQUIRED portaudio-2.0)
pkg_check_modules(STB REQUIRED IMPORTED_TARGET stb)
find_package(CLI11 REQUIRED)
find_package(draco REQUIRED)
find_package(glfw3 3.3 REQUIRED)
find_package(glm REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(SQLite3 3.37 REQUIRED) # strict tables
find_package(tomlplusplus REQUIRED)
find_package(ZLIB REQUIRED)
if(SPRINGDRIVE_CHARTS) # which need CVODE, and with it a hundred more packages than all else
    find_package(SUNDIALS REQUIRED COMPONENTS cvode)
endif()
find_file(SPRINGDRIVE_FONT DejaVuSans.ttf
    PATHS /usr/share/fonts/truetype/dejavu /usr/share/fonts/dejavu /usr/share/fonts/TTF
    REQUIRED)
set(font SPRINGDRIVE_FONT="${SPRINGDRIVE_FONT}")
set(version SPRINGDRIVE_VERSION="${PROJECT_VERSION}")

closed_library(cli11 CLI11::CLI11 CLI/CLI.hpp)
closed_library(draco draco::draco
    draco/compression/decode.h draco/compression/encode.h draco/core/decoder_buffer.h draco/mesh/mesh.h)
closed_library(epoxy PkgConfig::EPOXY epoxy/gl.h)
closed_library(glfw glfw GLFW/glfw3.h)
closed_library(json nlohmann_json::nlohmann_json nlohmann/json.hpp)
closed_library(libmd PkgConfig::MD sha2.h)
closed_library(libusb PkgConfig::LIBUSB libusb-1.0/libusb.h)
closed_library(matio PkgConfig::MATIO matio.h)
closed_library(meshoptimizer meshoptimizer::meshoptimizer meshoptimizer.h)
# Its library alone: the flag -pthread does not fit the precompiled headers.
closed_library(portaudio "${PORTAUDIO_LINK_LIBRARIES}" portaudio.h)
closed_library(sqlite3 SQLite::SQLite3 sqlite3.h)
closed_library(sundials SUNDIALS::cvode
    arkode/arkode.h cvode/cvode.h nvector/nvector_serial.h sundials/sundials_types.h
    sunlinsol/sunlinsol_dense.h sunmatrix/sunmatrix_dense.h)
closed_library(tinygltf PkgConfig::STB tiny_gltf.h)
closed_library(tomlplusplus tomlplusplus::tomlplusplus toml++/toml.h)
closed_library(zlib ZLIB::ZLIB zlib.h)

# Common basis: vectors, errors, fields and tables, lock-free data exchange, strict TOML.
room(base PLACES base OPENS libmd tomlplusplus
    PUBLIC_LIBRARIES springdrive_options Eigen3::Eigen fmt::fmt Threads::Threads)

# ---- device: what is in the hand, real or simulated
# The device interface, device files, kinematics and motors.
room(device PLACES device/core USES base winding_balance)
# What a board computes of a winding, too.
room(winding_balance PLACES device/core/motor/winding_balance.h PUBLIC_LIBRARIES springdrive_options)
# The simulated plant: linkage, motors, encoders and hand.
room(simulated PLACES device/simulated USES device)
# The wire protocol, for both ends.
room(usb_protocol PLACES device/usb/protocol.h PUBLIC_LIBRARIES springdrive_options)
# The core of a board's firmware; device/usb/board/arm/build compiles it for a Cortex-M4.
room(usb_board PLACES device/usb/board USES usb_protocol winding_balance EXCEPT /arm/
    LIBRARIES Eigen3::Eigen fmt::fmt) # only for the precompiled headers
# A board as a haptic device, over libusb or in process.
room(usb_driver PLACES device/usb/driver USES usb_protocol device OPENS libusb)
# An emulated board: the core with the simulated plant behind it, in process or as a USB device.
room(usb_emulator PLACES device/usb/emulator USES usb_board simulated)
# Selects and opens a device by name.
room(factory PLACES device/factory USES simulated usb_driver usb_emulator)

# ---- engine: haptic rendering; no window, no threads except its own
# The values that the proxy passes to control: the only part of contact that control can include.
room(contact_values PLACES engine/contact/contact.h USES base)
# Meshes, spatial search and the proxy.
room(contact PLACES engine/contact/mesh engine/contact/bvh engine/contact/proxy
    USES contact_values base)
# Velocity filter, drift compensation, maps, coupling: pure mathematics.
room(control PLACES engine/control USES contact_values device)
# Converts glTF to a scene: visual mesh, haptic surface, η.
room(scene PLACES engine/scene USES contact device OPENS draco json meshoptimizer tinygltf)
# The servo loop, its clock and the safety monitor.
room(servo PLACES engine/servo USES control contact device)
# Telemetry columns, recorder, reader, replay, export.
room(record PLACES engine/record USES servo OPENS json matio zlib)
# Linear theory of the sampled loops.
room(loops PLACES engine/lab/loops USES control)
# Scenarios, paths, brute-force references, plants for other integrators.
room(rig PLACES engine/lab/rig USES servo scene simulated)
# The model of a scene, as values, and who chooses it: all that a session and the lab share of it.
room(scene_model PLACES engine/session/model USES scene control simulated)
# Selection of the cheapest model within a scene's tolerance.
room(model_selection PLACES engine/lab/model_selection USES rig scene_model OPENS json meshoptimizer)
# Where methods fail: predicted and measured limits.
room(limits PLACES engine/lab/limits USES loops rig)
if(SPRINGDRIVE_CHARTS)
    # Cost and error of every method.
    room(charts PLACES engine/lab/charts USES limits OPENS sundials)
endif()
# Device, scene, servo and record combined, for windows, commands and studies.
room(session PLACES engine/session USES record scene_model factory OPENS json EXCEPT /model/)
# A device's first hour: is it what its file says, and how does it differ.
room(commissioning PLACES engine/commissioning USES device servo loops)

# ---- engine/study: pilot studies
# Methods of psychophysics: which stimulus comes next. Pure mathematics.
room(study_methods PLACES engine/study/methods USES base)
# What trials say: fitted functions, thresholds, groups; and what a plan of trials would say.
room(study_analysis PLACES engine/study/analysis USES study_methods)
# Stimuli: what the servo is told tick by tick to present one, and what of it was delivered.
room(study_stimuli PLACES engine/study/stimuli USES servo)
# Protocols of studies: files, and what is checked of them before anybody sits down.
room(study_protocol PLACES engine/study/protocol USES study_analysis study_stimuli limits)
# Trials on disk: one SQLite file a study.
room(study_store PLACES engine/study/store USES base OPENS sqlite3)
# Trials and answers for other programs: CSV and BIDS.
room(study_export PLACES engine/study/export USES study_protocol study_store OPENS json)
# A study as it is run: which trial comes next, what is stored of it, and when a session ends.
room(study_conduct PLACES engine/study/conduct USES study_protocol study_store)
# Simulated participants: they feel what the simulated device delivers, and answer.
room(study_observers PLACES engine/study/observers USES study_conduct)
# What a study's trials say: where each participant stands, thresholds, fits, groups, traces.
room(study_results PLACES engine/study/results USES study_conduct study_analysis)

# ---- app: what is seen and typed
# The 3-D view: OpenGL only, no window and no panels.
room(view PLACES app/view USES scene device OPENS epoxy PUBLIC_LIBRARIES PkgConfig::EPOXY glm::glm)
# What the program asks of the computer: its folders, files, programs and signals.
room(host PLACES app/host USES base DEFINES SPRINGDRIVE_ASSET_DIR="${SPRINGDRIVE_ASSET_DIR}")
# A window with Dear ImGui in it, and widgets that report what they show.
room(ui PLACES app/widgets app/window USES host record OPENS epoxy glfw json
    PUBLIC_LIBRARIES PkgConfig::IMGUI LIBRARIES PkgConfig::STB DEFINES GLFW_INCLUDE_NONE ${font})
# What a computer allows and lacks.
room(doctor PLACES app/doctor USES host record usb_driver OPENS glfw json
    DEFINES GLFW_INCLUDE_NONE ${font})
# Plots of channels, what channels mean, and the tools of an oscilloscope: spectrum, trigger, histogram.
room(plots PLACES app/plots USES ui session loops)
# Panels, and the data that they show and change.
room(panels PLACES app/panels USES view plots doctor limits)
# The loop of frames, a session's opening, and its hand and camera by mouse: for all windows.
room(stage PLACES app/stage USES view ui session OPENS epoxy)
# The demo's window, with the assistant for a new device, and the exhibit, which runs by itself.
room(demo PLACES app/assistant app/demo app/exhibit USES panels stage commissioning OPENS epoxy)
# What masks the sound of a device while there is a study.
room(study_sound PLACES app/study/sound USES base OPENS portaudio)
# The windows of a study's session, and the one for visitors.
room(study_screen
    PLACES app/study/experimenter app/study/participant app/study/session app/visitors
    USES stage study_sound study_observers study_results OPENS epoxy glfw
    DEFINES GLFW_INCLUDE_NONE ${font} ${version})
# The command line: everything except main, so that tests can call it.
if(SPRINGDRIVE_CHARTS)
    set(charts charts)
    set(without no_chart_command)
else()
    set(charts)
    set(without /chart_command speed_accuracy_marks)
endif()
room(cli PLACES app/commands app/figures
    USES demo study_screen study_export model_selection ${charts}
    OPENS cli11 epoxy json EXCEPT ${without} DEFINES ${version})

# The implementation of tinygltf; and a class with types of an unnamed namespace, which must be in
# the main file.
set_source_files_properties(engine/scene/gltf_parse.cpp device/usb/emulator/gadget.cpp
    PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

# shaders/lit.frag is springdrive::shaders::lit_frag, a std::string_view, in a header that is written
# again whenever one of them changes.
file(GLOB shaders CONFIGURE_DEPENDS shaders/*)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${shaders})
set(text "#pragma once\n\n#include <string_view>\n\nnamespace springdrive::shaders {\n")
string(APPEND text "// NOLINTBEGIN(readability-identifier-naming): named after their files\n")
foreach(shader IN LISTS shaders)
    cmake_path(GET shader FILENAME name)
    string(MAKE_C_IDENTIFIER ${name} name)
    file(READ ${shader} source)
    string(APPEND text "inline constexpr std::string_view ${name} = R\"glsl(${source})glsl\";\n")
endforeach()
file(CONFIGURE OUTPUT generated/app/view/embedded_shaders.h @ONLY
    CONTENT "${text}// NOLINTEND(readability-identifier-naming)\n} // namespace springdrive::shaders\n")
target_include_directories(view PUBLIC ${PROJECT_BINARY_DIR}/generated)
