// The list of shapes: signed distance and normal, thickness.
#pragma once

#include "geometry/height_view.hpp"
#include "geometry/sdf_view.hpp"
#include "math/standard.hpp"

namespace neve {

// A plane is z = 0 with the outside above it; a cylinder's axis is z; meshes and terrain are sampled on grids. Sizes are
// `half` [m]: half edges of a box, (radius, -, half height) of a cylinder, (radius, -, -) of a sphere.
enum class Shape { plane, box, sphere, cylinder, mesh, terrain };
inline constexpr const char* shape_names[] = {"plane", "box", "sphere", "cylinder", "mesh", "terrain"};

// Whether a shape is given by samples rather than by a formula and sizes.
inline bool is_sampled(Shape shape) { return shape == Shape::mesh || shape == Shape::terrain; }

// The least distance between opposite sides [m] of a shape with an exact distance.
template <class T>
T thickness_of(Shape shape, const Vec3<T>& half) {
  switch (shape) {
    case Shape::box: return 2 * min(half.x, min(half.y, half.z));
    case Shape::sphere: return 2 * half.x;
    case Shape::cylinder: return 2 * min(half.x, half.z);
    default: return std::numeric_limits<T>::max();
  }
}

// Whether a ball can hold the shape.
inline bool is_bounded(Shape shape) { return shape != Shape::plane && shape != Shape::terrain; }

// The radius of the smallest ball around the middle of a bounded shape with a formula [m].
template <class T>
T bounding_radius(Shape shape, const Vec3<T>& half) {
  switch (shape) {
    case Shape::box: return std::sqrt(dot(half, half));
    case Shape::sphere: return half.x;
    case Shape::cylinder: return std::sqrt(half.x * half.x + half.z * half.z);
    default: return std::numeric_limits<T>::max();
  }
}

// The axis (0, 1, 2) along which a shape is longest; of a round one, its own.
template <class T>
int longest_axis(Shape shape, const Vec3<T>& half) {
  if (shape != Shape::box) return 2;
  return half.x >= half.y && half.x >= half.z ? 0 : half.y >= half.z ? 1 : 2;
}

namespace detail {

template <class R>
inline Surface<R> sphere_surface(const Vec3<R>& x, scalar_t<R> radius) {
  const R zero = splat<R>(0), one = splat<R>(1);
  const R r = sqrt(dot(x, x));
  const auto off_centre = r > zero;
  const Vec3<R> n = x * (one / select(off_centre, r, one));
  return {r - radius, select(off_centre, n, Vec3<R>{zero, zero, one})};
}

template <class R>
inline R sign_of(R a) {
  return select(a < splat<R>(0), splat<R>(-1), splat<R>(1));
}

template <class R>
inline Surface<R> box_surface(const Vec3<R>& x, const Vec3<scalar_t<R>>& half) {
  const R zero = splat<R>(0), one = splat<R>(1);
  const Vec3<R> sign{sign_of(x.x), sign_of(x.y), sign_of(x.z)};
  const Vec3<R> q{abs(x.x) - half.x, abs(x.y) - half.y, abs(x.z) - half.z};
  const Vec3<R> out{max(q.x, zero), max(q.y, zero), max(q.z, zero)};
  const R far = sqrt(dot(out, out));
  const auto outside = far > zero;
  // inside: the nearest face
  const R inner = max(q.x, max(q.y, q.z));
  const R nx = select(q.x >= inner, one, zero);
  const R ny = select(q.y >= inner, one - nx, zero), nz = one - nx - ny;
  const R inv = one / select(outside, far, one);
  const Vec3<R> n = select(outside, out * inv, Vec3<R>{nx, ny, nz});
  return {select(outside, far, inner), {n.x * sign.x, n.y * sign.y, n.z * sign.z}};
}

template <class R>
inline Surface<R> cylinder_surface(const Vec3<R>& x, scalar_t<R> radius, scalar_t<R> half_height) {
  const R zero = splat<R>(0), one = splat<R>(1);
  const R r = sqrt(x.x * x.x + x.y * x.y);
  const auto off_axis = r > zero;
  const R inv_r = one / select(off_axis, r, one);
  const Vec3<R> radial{select(off_axis, x.x * inv_r, one), x.y * inv_r, zero};
  const Vec3<R> axial{zero, zero, sign_of(x.z)};
  const R side = r - radius, cap = abs(x.z) - half_height;
  const R out_side = max(side, zero), out_cap = max(cap, zero);
  const R far = sqrt(out_side * out_side + out_cap * out_cap);
  const auto outside = far > zero;
  const R inv = one / select(outside, far, one);
  const Vec3<R> face = select(side > cap, radial, axial);
  const Vec3<R> edge = radial * (out_side * inv) + axial * (out_cap * inv);
  return {select(outside, far, max(side, cap)), select(outside, edge, face)};
}

}  // namespace detail

// A shape in its place. Meshes and terrain have samples, the others a size.
template <class T>
struct PlacedShape {
  Shape kind;
  Vec3<T> half;                         // sizes [m]
  Vec3<T> centre;                       // of its frame [m]; a plane passes through it
  Mat3<T> rotation;                     // local to world
  const SdfView* mesh = nullptr;        // of Shape::mesh
  const HeightView* terrain = nullptr;  // of Shape::terrain
  bool operator==(const PlacedShape&) const = default;
};

// A point as a shape's own frame has it.
template <class T>
inline Vec3<double> local_of(const PlacedShape<T>& shape, const Vec3<T>& x) {
  const Vec3<T> local = transposed_times(shape.rotation, x - shape.centre);
  return {double(local.x), double(local.y), double(local.z)};
}

// Lanes that are not of the mask `wanted` mean nothing: samples are read for the others alone.
template <class R, class M>
inline Surface<R> surface(const PlacedShape<scalar_t<R>>& shape, const Vec3<R>& x, const M& wanted) {
  const Mat3<R> to_world{spread<R>(shape.rotation.c0), spread<R>(shape.rotation.c1),
                         spread<R>(shape.rotation.c2)};
  const Vec3<R> local = transposed_times(to_world, x - spread<R>(shape.centre));
  Surface<R> s{};
  switch (shape.kind) {
    case Shape::plane: return {local.z, to_world.c2};
    case Shape::sphere: s = detail::sphere_surface(local, shape.half.x); break;
    case Shape::box: s = detail::box_surface(local, shape.half); break;
    case Shape::cylinder: s = detail::cylinder_surface(local, shape.half.x, shape.half.z); break;
    case Shape::mesh: s = shape.mesh->at(local, wanted); break;
    case Shape::terrain: s = shape.terrain->at(local); break;
  }
  return {s.phi, to_world * s.normal};
}
template <class R>
inline Surface<R> surface(const PlacedShape<scalar_t<R>>& shape, const Vec3<R>& x) {
  return surface(shape, x, R{} == R{});
}

// What `surface` says of points of a mesh does not fall below this [m], which costs a sample where `surface` takes eight.
// Lanes that are not of the mask `wanted` mean nothing.
template <class R, class M>
inline R least_at(const PlacedShape<scalar_t<R>>& mesh, const Vec3<R>& x, const M& wanted) {
  const Mat3<R> to_world{spread<R>(mesh.rotation.c0), spread<R>(mesh.rotation.c1),
                         spread<R>(mesh.rotation.c2)};
  return mesh.mesh->least_at(transposed_times(to_world, x - spread<R>(mesh.centre)), wanted);
}

// Whether the surface or the inside of a shape may be within `reach` [m] of x; false only if it is not.
template <class T>
inline bool is_near(const PlacedShape<T>& shape, const Vec3<T>& x, T reach) {
  if (!shape.mesh && !shape.terrain) return surface(shape, x).phi <= reach;
  const Vec3<double> at = local_of(shape, x);
  return shape.mesh ? shape.mesh->is_near(at, double(reach)) : shape.terrain->is_near(at, double(reach));
}

}  // namespace neve
