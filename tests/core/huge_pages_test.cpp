// SPDX-License-Identifier: Apache-2.0
#include "manylight/core/huge_pages.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

namespace manylight::huge_pages_test {
namespace {

// Growth from plain memory to aligned pages and back keeps the contents. Planted bug seen to fail: pages at multiples
// of 64.
TEST(HugePages, TablesKeepTheirContentsAcrossTheirSizes) {
  constexpr std::size_t k_page = HugePageAllocator<std::uint32_t>::k_page;
  LargeVector<std::uint32_t> table(3);
  std::iota(table.begin(), table.end(), 0U);
  table.resize(2 * k_page / sizeof(std::uint32_t) + 1);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(table.data()) % k_page, 0U);
  std::iota(table.begin() + 3, table.end(), 3U);
  LargeVector<std::uint32_t> moved = std::move(table);
  for (std::size_t i = 0; i < moved.size(); ++i) ASSERT_EQ(moved[i], i);
  moved.resize(5);
  moved.shrink_to_fit();
  EXPECT_EQ(moved, (LargeVector<std::uint32_t>{0, 1, 2, 3, 4}));
}

// Planted bug seen to fail: sizes that overflow not caught.
TEST(HugePages, RefusesWhatCannotBe) {
  HugePageAllocator<double> allocator;
  EXPECT_THROW(static_cast<void>(allocator.allocate(std::numeric_limits<std::size_t>::max() / 4)), std::bad_alloc);
}

}  // namespace
}  // namespace manylight::huge_pages_test
