// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/embree.hpp"

#include "geometry/backend_suite.hpp"

namespace manylight::test {
INSTANTIATE_TYPED_TEST_SUITE_P(Embree, BackendSuite, EmbreeGeometry);
}  // namespace manylight::test
