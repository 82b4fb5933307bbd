// SPDX-License-Identifier: Apache-2.0
// expect: deleted
// expect: operator bool
#include "manylight/core/interval.hpp"

namespace {

/// A pattern as a beginner writes it: for an interval that contains 0 both answers are right.
template <class Cosine>
Cosine clamped(const Cosine& c) {
#ifdef MANYLIGHT_CORRECT
  return manylight::select(c > 0.0F, c, 0.0F);
#else
  if (c > 0.0F) return c;
  return 0.0F;
#endif
}

}  // namespace

int main() {
  const auto range = clamped(manylight::Interval<float>(-1.0F, 1.0F));
  return clamped(0.5F) == 0.5F && range.lo == 0.0F && range.hi == 1.0F ? 0 : 1;
}
