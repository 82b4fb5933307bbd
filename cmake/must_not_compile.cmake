# SPDX-License-Identifier: Apache-2.0
# cmake -D COMPILER= -D SOURCE= -D INCLUDES= [-D SYSTEM_INCLUDES=] -P must_not_compile.cmake
# See tests/compile_fail/CMakeLists.txt.

set(command ${COMPILER} -std=c++20 -fsyntax-only -fdiagnostics-color=never)
foreach(folder IN LISTS INCLUDES)
  list(APPEND command -I${folder})
endforeach()
foreach(folder IN LISTS SYSTEM_INCLUDES)
  if(NOT folder STREQUAL "/usr/include")  # as -isystem it would hide the C library behind the C++ library's wrappers
    list(APPEND command -isystem ${folder})
  endif()
endforeach()

file(STRINGS ${SOURCE} expectations REGEX "^// expect: ")
if(NOT expectations)
  message(FATAL_ERROR "${SOURCE}: no line '// expect: <regex>'")
endif()

execute_process(COMMAND ${command} -DMANYLIGHT_CORRECT ${SOURCE} RESULT_VARIABLE result ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "the correct variant of ${SOURCE} does not compile:\n${output}")
endif()
execute_process(COMMAND ${command} ${SOURCE} RESULT_VARIABLE result ERROR_VARIABLE output)
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE} compiles, but must not")
endif()
foreach(expectation IN LISTS expectations)
  string(REGEX REPLACE "^// expect: " "" expectation "${expectation}")
  if(NOT output MATCHES "${expectation}")
    message(FATAL_ERROR "${SOURCE}: no '${expectation}' in the compiler's output:\n${output}")
  endif()
endforeach()
