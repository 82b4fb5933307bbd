// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>

namespace manylight::compare {

/// The program manylight-compare: results go to `out`, at most one line to `errors`.
/// Returns 0, 1 when a test was asked for and failed, or 2 for bad input.
[[nodiscard]] int run_compare(int argc, const char* const* argv, std::ostream& out, std::ostream& errors);

}  // namespace manylight::compare
