# SPDX-License-Identifier: Apache-2.0
# One target per optional package; link it where its bridge header is included:
#   manylight::tbb     manylight/core/tbb_executor.hpp
#   manylight::embree  manylight/geometry/embree.hpp
# Also included by the installed package, where MANYLIGHT_HAS_* tell what was found there.

if(MANYLIGHT_HAS_TBB AND NOT TARGET manylight::tbb)
  add_library(manylight::tbb INTERFACE IMPORTED)
  target_link_libraries(manylight::tbb INTERFACE manylight::manylight TBB::tbb)
endif()
if(MANYLIGHT_HAS_EMBREE AND NOT TARGET manylight::embree)
  add_library(manylight::embree INTERFACE IMPORTED)
  target_link_libraries(manylight::embree INTERFACE manylight::manylight embree)
endif()
