# A room is a target that can include only the headers of the rooms that it uses. The top folder of
# the project is on no include path: each room has its own include folder in the build tree,
# rooms/NAME, with links to its headers. So "engine/control/tuning.h" is found under its full name,
# but only by targets that link `control`.
#
#   room(NAME [PLACES place...] [USES room...] [PUBLIC_LIBRARIES library...] [LIBRARIES library...]
#        [OPENS closed...] [EXCEPT pattern...])
#
# A place is a folder or a header, by its path from the top folder; default: the current folder.
# A room's sources are all .cpp files below its folders but those that match an EXCEPT pattern.
# Headers of PUBLIC_LIBRARIES are also visible to users of the room. OPENS names the libraries of
# the list below that the room itself may include. What each room is, uses and opens is written to
# rooms.txt in the build tree: NAME | place... | room... | closed...
file(WRITE ${PROJECT_BINARY_DIR}/rooms.txt "")

# External headers are in /usr/include, which every compiler searches. For a library that a room
# does not open, headers of the same names with an #error directive therefore precede them.
set(closed_libraries
    cli11 draco epoxy glfw json libmd libusb matio meshoptimizer portaudio sqlite3 sundials tinygltf tomlplusplus zlib)
set(closed_cli11 CLI/CLI.hpp)
set(closed_draco
    draco/compression/decode.h draco/compression/encode.h draco/core/decoder_buffer.h draco/mesh/mesh.h)
set(closed_epoxy epoxy/gl.h)
set(closed_glfw GLFW/glfw3.h)
set(closed_json nlohmann/json.hpp)
set(closed_libmd sha2.h)
set(closed_libusb libusb-1.0/libusb.h)
set(closed_matio matio.h)
set(closed_meshoptimizer meshoptimizer.h)
set(closed_portaudio portaudio.h)
set(closed_sqlite3 sqlite3.h)
set(closed_sundials
    arkode/arkode.h cvode/cvode.h nvector/nvector_serial.h sundials/sundials_types.h
    sunlinsol/sunlinsol_dense.h sunmatrix/sunmatrix_dense.h)
set(closed_tinygltf tiny_gltf.h)
set(closed_tomlplusplus toml++/toml.h)
set(closed_zlib zlib.h)

function(room name)
    cmake_parse_arguments(ROOM "" ""
        "PLACES;USES;PUBLIC_LIBRARIES;LIBRARIES;OPENS;EXCEPT" ${ARGN})
    if(NOT ROOM_PLACES)
        cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR}
            OUTPUT_VARIABLE ROOM_PLACES)
    endif()
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
    list(TRANSFORM sources PREPEND ${PROJECT_SOURCE_DIR}/)

    if(NOT sources)
        add_library(${name} INTERFACE)
        target_include_directories(${name} INTERFACE ${headers})
        target_link_libraries(${name} INTERFACE ${ROOM_PUBLIC_LIBRARIES} ${ROOM_USES})
        return()
    endif()
    add_library(${name} STATIC ${sources})
    target_include_directories(${name} PUBLIC ${headers})
    target_link_libraries(${name} PUBLIC ${ROOM_PUBLIC_LIBRARIES} ${ROOM_USES}
                                  PRIVATE ${ROOM_LIBRARIES})
    target_precompile_headers(${name} REUSE_FROM precompiled)
    set(closed ${PROJECT_BINARY_DIR}/rooms/closed/${name})
    file(REMOVE_RECURSE ${closed})
    foreach(library IN LISTS closed_libraries)
        if(NOT library IN_LIST ROOM_OPENS)
            foreach(header IN LISTS closed_${library})
                file(WRITE ${closed}/${header} "#error \"closed to this room: ${library}\"\n")
            endforeach()
        endif()
    endforeach()
    target_include_directories(${name} PRIVATE ${closed})
endfunction()
