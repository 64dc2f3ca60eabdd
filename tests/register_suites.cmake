# Run after a test program was linked: writes `file` with the program's tests for CTest. A suite is one
# test of CTest, as starting a program takes longer than most tests; one whose filter is in `long` is
# a test of its own.
#   cmake -D program=… -D file=… -D labels=… -D long=… -D timeout_s=… -D folder=… -P register_suites.cmake
set(tests "")

function(add name filter labels)
    string(APPEND tests "add_test([=[${name}]=] [=[${program}]=] [=[--gtest_filter=${filter}]=])\n"
        "set_tests_properties([=[${name}]=] PROPERTIES WORKING_DIRECTORY [=[${folder}]=] "
        "SKIP_RETURN_CODE 77 TIMEOUT ${timeout_s} LABELS [=[${labels}]=])\n")
    set(tests "${tests}" PARENT_SCOPE)
endfunction()

# Sets `listed` to the suites, "Suite.", and the tests, "  Test", that pass a filter.
function(list_tests filter)
    execute_process(COMMAND ${program} --gtest_list_tests --gtest_filter=${filter}
        OUTPUT_VARIABLE text TIMEOUT 60 COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE " *#[^\n]*" "" text "${text}") # the values of parameters
    string(REGEX MATCHALL "[^\n]+" listed "${text}")
    list(FILTER listed INCLUDE REGEX "^[^ ]+[.]$|^  [^ ]+$")
    set(listed "${listed}" PARENT_SCOPE)
endfunction()

list_tests("*-${long}")
list(FILTER listed INCLUDE REGEX "[.]$")
foreach(suite IN LISTS listed)
    string(REGEX REPLACE "[.]$" "" name "${suite}")
    add("${name}" "${suite}*-${long}" "${labels}")
endforeach()
if(long)
    list_tests("${long}")
    foreach(line IN LISTS listed)
        if(line MATCHES "[.]$")
            set(suite "${line}")
        else()
            string(REPLACE " " "" name "${suite}${line}")
            add("${name}" "${name}" "${labels}+long")
        endif()
    endforeach()
endif()
file(WRITE "${file}" "${tests}")
