// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/embree.hpp"

#include "integrator/analytic_suite.hpp"
#include "integrator/stability_suite.hpp"

namespace manylight::test {
INSTANTIATE_TYPED_TEST_SUITE_P(Embree, AnalyticSuite, EmbreeGeometry);
INSTANTIATE_TYPED_TEST_SUITE_P(Embree, StabilitySuite, EmbreeGeometry);
}  // namespace manylight::test
