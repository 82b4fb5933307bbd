# SPDX-License-Identifier: Apache-2.0
# Everything a user may set. What builds our own programs and tests is on only when manylight is the top project.

option(MANYLIGHT_BUILD_PROGRAMS "Build manylight-render and manylight-compare" ${PROJECT_IS_TOP_LEVEL})
option(MANYLIGHT_BUILD_TESTS "Build the tests" ${PROJECT_IS_TOP_LEVEL})
option(MANYLIGHT_BUILD_EXAMPLES "Build the examples" ${PROJECT_IS_TOP_LEVEL})
option(MANYLIGHT_BUILD_BENCHMARKS "Build the benchmarks" OFF)
option(MANYLIGHT_INSTALL "Install the headers, the CMake package and the programs" ${PROJECT_IS_TOP_LEVEL})

option(MANYLIGHT_RENDER_EMBREE "Offer Embree in manylight-render where it was found: twice the compile time" ON)

foreach(package IN ITEMS EMBREE TBB NANOVDB)
  set(MANYLIGHT_WITH_${package} AUTO CACHE STRING "Use the optional package: AUTO (when found), ON (required) or OFF")
  set_property(CACHE MANYLIGHT_WITH_${package} PROPERTY STRINGS AUTO ON OFF)
endforeach()

# The following concern only our own programs, tests, examples and benchmarks; nothing is passed on to users.
option(MANYLIGHT_NATIVE "Compile our own targets for the processor of this machine" ${PROJECT_IS_TOP_LEVEL})
option(MANYLIGHT_WARNINGS_AS_ERRORS "Treat warnings in our own targets as errors" OFF)
option(MANYLIGHT_CCACHE "Compile through ccache when it is installed" ${PROJECT_IS_TOP_LEVEL})
set(MANYLIGHT_SLOW_TESTS RUN CACHE STRING "Slow tests: RUN, COMPILE (without optimisation or sanitizers) or OFF")
set_property(CACHE MANYLIGHT_SLOW_TESTS PROPERTY STRINGS RUN COMPILE OFF)
option(MANYLIGHT_COMPILER_TESTS "Test that misuse of the headers does not compile" ON)
option(MANYLIGHT_HEADERS_ALONE "Compile each header alone" ON)
set(MANYLIGHT_SANITIZE "" CACHE STRING "Sanitizers for our own targets, as after -fsanitize=, e.g. address,undefined")
set(MANYLIGHT_REFERENCE_SCENES "" CACHE PATH
    "Folder with reference scenes and images; when set, a test that skips for want of them fails")

# Only a top project chooses a build type, and only when nobody else has.
get_property(multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
if(PROJECT_IS_TOP_LEVEL AND NOT multi_config AND NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_CXX_EXTENSIONS OFF)
endif()

if(MANYLIGHT_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(MANYLIGHT_CCACHE_PROGRAM ccache)
  if(MANYLIGHT_CCACHE_PROGRAM)
    set(CMAKE_CXX_COMPILER_LAUNCHER "${MANYLIGHT_CCACHE_PROGRAM}")
  endif()
endif()
