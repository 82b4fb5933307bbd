// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Forward declarations: enough to name the types in a user's header, at next to no compile time.

#include <concepts>

namespace manylight {

template <std::floating_point S>
struct Frame;
template <std::floating_point S>
struct Box;
template <std::floating_point S>
struct Ray;
template <std::floating_point S>
struct Hit;
template <std::floating_point S>
struct SurfacePoint;
template <std::floating_point S>
struct TriangleMesh;
template <std::floating_point S>
struct Sphere;
template <std::floating_point S>
struct Disk;
template <std::floating_point S>
struct Shapes;
template <std::floating_point S>
struct IndependentSampler;
template <std::floating_point S>
struct DirectionSample;
template <std::floating_point S>
struct Lambertian;
template <std::floating_point S>
struct Photon;
struct SerialExecutor;

}  // namespace manylight
