// SPDX-License-Identifier: Apache-2.0
// A user's program: it must build with nothing but what the consumer projects beside it state.
#include "manylight/manylight.hpp"

#ifdef CONSUMER_TBB
#include "manylight/core/tbb_executor.hpp"
#endif
#ifdef CONSUMER_EMBREE
#include "manylight/geometry/embree.hpp"
#endif

int main() {
  const manylight::Frame<double> frame(manylight::Vec3<double>(0, 0, 1));
  const double length = glm::length(frame.to_world(manylight::Vec3<double>(0, 0, 2)));
  return length == 2.0 ? 0 : 1;
}
