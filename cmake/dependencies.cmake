# SPDX-License-Identifier: Apache-2.0
# Packages of the headers: two required, two optional. Config files of distributions report inexact versions
# (nanoflann 1.4.2 for 1.4.3), so none is asked for.

find_package(glm CONFIG REQUIRED)
find_package(nanoflann CONFIG REQUIRED)

# find_optional(<option> <package> <target>): sets <option's suffix>_FOUND as MANYLIGHT_HAS_<suffix>.
function(manylight_find_optional suffix package target)
  set(found OFF)
  if(NOT MANYLIGHT_WITH_${suffix} STREQUAL "OFF")
    find_package(${package} CONFIG QUIET)
    if(TARGET ${target})
      set(found ON)
    elseif(NOT MANYLIGHT_WITH_${suffix} STREQUAL "AUTO")
      message(FATAL_ERROR "MANYLIGHT_WITH_${suffix} is ${MANYLIGHT_WITH_${suffix}}, but ${package} was not found")
    endif()
  endif()
  set(MANYLIGHT_HAS_${suffix} ${found} PARENT_SCOPE)
  message(STATUS "manylight: ${package} ${found} (MANYLIGHT_WITH_${suffix}=${MANYLIGHT_WITH_${suffix}})")
endfunction()

manylight_find_optional(TBB TBB TBB::tbb)
manylight_find_optional(EMBREE embree embree)
