// Surfaces of solids as particles (Akinci et al. 2012): where they are, and the volume that each stands for.
#pragma once

#include "mpm/model.hpp"
#include "neighbours/cubic_kernel.hpp"
#include "neighbours/search.hpp"

namespace neve {

// V_b sum_b' W_bb' of boundary particles [1]: that of both public ports of Gissler et al. 2020. With 2.2 / pi = 0.70 a layer
// of them would stand for one layer of snow; it is softer, and snow sinks farther in.
inline constexpr double boundary_share = 0.8;

// Points in some order, with what they need to be sorted.
template <class T>
struct SphBoundary {
  std::size_t count = 0;
  Field<T, 3> x, v, normal;    // position [m], velocity [m/s], out of the solid [1]
  Field<T, 1> V;               // volume [m3]
  Column<std::int32_t> solid;  // index of the solid
  Column<std::uint32_t> id;    // number in the order in which they were given

  template <class F>
  void each_column(F&& f) {
    for (int k = 0; k < 3; ++k) f(x.column(k)), f(v.column(k)), f(normal.column(k));
    f(V.column(0)), f(solid.data()), f(id.data());
  }
  void resize(std::size_t n) {
    if (id.size() == n) return;
    x.resize(n), v.resize(n), normal.resize(n), V.resize(n), solid.resize(n), id.resize(n);
    count = n;
  }
};

// The boundary in the frames of its solids: x there, and the normal.
template <class T>
struct SphBoundarySamples {
  std::size_t count = 0;
  std::size_t evaluated = 0;  // kernels that volumes have taken so far
  Field<T, 3> x, normal;
  Field<T, 1> V;
  Column<std::int32_t> solid;

  void resize(std::size_t n) {
    x.resize(n), normal.resize(n), V.resize(n), solid.resize(n);
    count = n;
  }

  // V_b = share / sum_b' W_bb', over the points of one solid, which stand together in the order of the solids.
  void set_volumes(const CubicKernel<T>& kernel) {
    for (std::size_t first = 0; first < count;) {
      std::size_t last = first;
      while (last < count && solid[last] == solid[first]) ++last;
      set_volumes(kernel, first, last);
      first = last;
    }
  }

  // Put the points where their solids are, into `out`, moved on by `after` [s] of the solids' free fall.
  void place(const Model<T>& world, double after, SphBoundary<T>& out) const {
    out.resize(count);
    each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const Solid<T>& s = world.solids[std::size_t(solid[b])];
        const Vec3<T> at = s.rotation * Vec3<T>{x.column(0)[b], x.column(1)[b], x.column(2)[b]} + s.centre;
        const Vec3<T> n = s.rotation * Vec3<T>{normal.column(0)[b], normal.column(1)[b], normal.column(2)[b]};
        Vec3<T> v = s.surface_velocity_at(at, n);
        if (s.body >= 0) {
          const Twist& free = world.bodies.free[std::size_t(s.body)];
          const Vec3<T> a{T(free[0]), T(free[1]), T(free[2])}, turn{T(free[3]), T(free[4]), T(free[5])};
          v = v + (a + cross(turn, at - s.centre)) * T(after);
        }
        for (int k = 0; k < 3; ++k)
          out.x.column(k)[b] = at[k], out.v.column(k)[b] = v[k], out.normal.column(k)[b] = n[k];
        out.V.column(0)[b] = V.column(0)[b];
        out.solid[b] = solid[b], out.id[b] = std::uint32_t(b);
      }
    });
  }

 private:
  struct Part {
    std::size_t count;
    Field<T, 3> x;
    Column<std::uint32_t> id;
    template <class F>
    void each_column(F&& f) {
      for (int k = 0; k < 3; ++k) f(x.column(k));
      f(id.data());
    }
  };

  void set_volumes(const CubicKernel<T>& kernel, std::size_t first, std::size_t last) {
    Part part{last - first, {}, {}};
    part.x.resize(part.count), part.id.resize(part.count);
    for (std::size_t b = 0; b < part.count; ++b) {
      for (int k = 0; k < 3; ++k) part.x.column(k)[b] = x.column(k)[first + b];
      part.id[b] = std::uint32_t(b);
    }
    std::vector<std::uint32_t> order, begin;
    std::vector<std::int32_t> rows;
    std::vector<detail::FoundRows> found;
    const Cells cells = cells_of(part, double(kernel.h), order);
    reorder(part, order);
    find_rows(part, cells, part, cells, kernel.h * kernel.h, found, begin, [&](std::size_t n) {
      rows.resize(n);
      return rows.data();
    });
    for (std::size_t b = 0; b < part.count; ++b) {
      T sum = kernel.at_zero();
      evaluated += 1 + begin[b + 1] - begin[b];
      for (std::uint32_t e = begin[b]; e < begin[b + 1]; ++e) {
        T r2 = 0;
        for (int k = 0; k < 3; ++k) {
          const T d = part.x.column(k)[b] - part.x.column(k)[std::size_t(rows[e])];
          r2 += d * d;
        }
        sum += kernel.value(r2);
      }
      V.column(0)[first + part.id[b]] = T(boundary_share) / sum;
    }
  }
};

}  // namespace neve
