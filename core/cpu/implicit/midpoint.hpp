// The implicit midpoint rule: the equations are solved for half of a step, so that they have the velocities w in its middle,
//
//   M (w - v_n - dt/2 g) = dt/2 f(x_n + dt/2 w),   x = x_n + dt w,   v = 2 w - v_n,
//
// of second order in dt. The nodes hold w while particles move and deform; what is then left for the particles to get is
// d = w - v_n. Where a surface holds a node d is zero: snow does not bounce.
#pragma once

#include "cpu/implicit/passes.hpp"

namespace neve {

// What particles get after they have moved.
template <class T>
class LateChange {
  using R = Lanes<T>;

 public:
  // Gather the change d of the nodes where the particles are now. `scale`: see ImplicitStep.
  template <class Spline, class Weights>
  void gather(const Model<T>& model, const State<T>& state, Grid<T>& grid, NodeField<T>& d, T scale) {
    if (state.count > v_.size()) v_.resize(state.count), C_.resize(state.count);
    each_gathered<Nothing, T, Spline, Weights>(
        model, state, grid, d, [&](std::size_t p, int count, const Vec3<R>& u, const Mat3<R>& G) {
          store_vector(v_, p, u, count);
          store_matrix(C_, p, scaled(G, scale), count);
          return Nothing{};
        });
    keeps_C_ = keeps_C(model);
    waits_ = state.count;
  }
  // Give it to them, in the order in which they were.
  void add_to(State<T>& state) {
    each_chunk(waits_, [&](int, std::size_t begin, std::size_t end) {
      for (int k = 0; k < 3; ++k) add(v_.column(k), state.v.column(k), begin, end);
      for (int k = 0; keeps_C_ && k < 9; ++k) add(C_.column(k), state.C.column(k), begin, end);
    });
    waits_ = 0;
  }

 private:
  struct Nothing {
    void merge(const Nothing&) {}
  };
  static void add(const T* from, T* to, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) to[p] += from[p];
  }
  Field<T, 3> v_;
  Field<T, 9> C_;
  std::size_t waits_ = 0;
  bool keeps_C_ = false;
};

}  // namespace neve
