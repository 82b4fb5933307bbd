// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Every macro of manylight. Users may define the first group before including any header.

// ---- user-settable -------------------------------------------------------------------------
#ifndef MANYLIGHT_ASSERT
#include <cassert>
/// Precondition check of inner loops; off under NDEBUG. Replaceable by a macro of the same form.
#define MANYLIGHT_ASSERT(condition) assert(condition)
#endif

// ---- version (read by CMake from here) -----------------------------------------------------
#define MANYLIGHT_VERSION_MAJOR 0
#define MANYLIGHT_VERSION_MINOR 1
#define MANYLIGHT_VERSION_PATCH 0
