# Embeds the text of shaders in a C++ header, which is regenerated whenever one of them changes.
#
#   embed_shaders(TARGET HEADER SHADER...)     paths relative to the top folder
#
# lets TARGET include "HEADER", in which shaders/lit.frag is `springdrive::shaders::lit_frag`, a
# std::string_view. The build runs this file as a script to write the header.

if(NOT CMAKE_SCRIPT_MODE_FILE)
    set(EMBED_SHADERS_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

    function(embed_shaders target header)
        set(folder ${PROJECT_BINARY_DIR}/generated)
        list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/ OUTPUT_VARIABLE shaders)
        add_custom_command(
            OUTPUT ${folder}/${header}
            COMMAND ${CMAKE_COMMAND} "-DHEADER=${folder}/${header}" "-DSHADERS=${shaders}"
                    -P ${EMBED_SHADERS_SCRIPT}
            DEPENDS ${shaders} ${EMBED_SHADERS_SCRIPT}
            COMMENT "Embedding shaders"
            VERBATIM)
        # By itself it needs nothing that the target needs: linters ask for the header alone.
        add_custom_target(${target}_shaders DEPENDS ${folder}/${header})
        add_dependencies(${target} ${target}_shaders)
        target_sources(${target} PRIVATE ${folder}/${header})
        target_include_directories(${target} PRIVATE ${folder})
    endfunction()
    return()
endif()

set(text "// Generated from shaders/ by app/view/embed_shaders.cmake.\n#pragma once\n\n")
string(APPEND text "#include <string_view>\n\nnamespace springdrive::shaders {\n")
string(APPEND text "// NOLINTBEGIN(readability-identifier-naming): named after their files\n")
foreach(shader IN LISTS SHADERS)
    cmake_path(GET shader FILENAME name)
    string(MAKE_C_IDENTIFIER ${name} name)
    file(READ ${shader} source)
    string(APPEND text "\ninline constexpr std::string_view ${name} = R\"glsl(${source})glsl\";\n")
endforeach()
string(APPEND text "\n// NOLINTEND(readability-identifier-naming)\n\n} // namespace springdrive::shaders\n")
file(WRITE ${HEADER} "${text}")
