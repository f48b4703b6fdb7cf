// Snow as smoothed particles (Gissler et al. 2020): what a particle owns, and what a step finds of it.
#pragma once

#include "mpm/state.hpp"
#include "neighbours/cubic_kernel.hpp"
#include "neighbours/gather.hpp"

namespace neve {

// Water among the snow: the particles of one material.
struct SphWater {
  int material = -1;                         // its row of the material table; none
  double rho0 = 1000, bulk_modulus = 2.2e9;  // [kg/m3], [Pa]
  double viscosity = 0;                      // [Pa s]
};

template <class T>
struct SphState {
  SphWater water;
  std::size_t count = 0;
  Field<T, 3> x, v;                        // position [m], velocity [m/s]
  Field<T, 9> F_E;                         // elastic deformation gradient, symmetric [1]
  Field<T, 1> m, V0;                       // mass [kg], volume at birth [m3]
  Field<T, 1> rho_birth;                   // rest density at birth; 0: it is not known yet [kg/m3]
  Field<T, 1> J_P;                         // that over the rest density now [1]
  Field<T, 1> stiffness, strength;         // factors on E0 and on the critical strains [1]
  Field<T, 1> p_last;                      // pressure of the last step, from which the next solve starts [Pa]
  Field<T, 3> a_last;                      // acceleration by shear of the last step, likewise [m/s2]
  Column<std::uint16_t> material, source;  // rows of the material table and of the scene's sources
  Column<std::uint32_t> id;                // birth number

  bool has_water() const { return water.material >= 0; }
  bool is_water(std::size_t p) const { return int(material[p]) == water.material; }

  template <class F>
  void each_column(F&& f) {
    each_field([&](auto& field) {
      for (int i = 0; i < field.components(); ++i) f(field.column(i));
    });
    f(material.data()), f(source.data()), f(id.data());
  }

  void resize(std::size_t n) {
    each_field([&](auto& field) { field.resize(n); });
    material.resize(n), source.resize(n), id.resize(n);
    for (std::size_t p = count; p < n; ++p) {
      J_P.column(0)[p] = stiffness.column(0)[p] = strength.column(0)[p] = T(1);
      for (int k : {0, 4, 8}) F_E.column(k)[p] = T(1);
      id[p] = static_cast<std::uint32_t>(p);
    }
    count = n;
  }

  std::size_t bytes() {
    std::size_t sum = count * (2 * sizeof(std::uint16_t) + sizeof(std::uint32_t));
    each_field([&](auto& field) { sum += field.bytes(); });
    return sum;
  }

 private:
  template <class F>
  void each_field(F&& f) {
    f(x), f(v), f(F_E), f(m), f(V0), f(rho_birth), f(J_P), f(stiffness), f(strength), f(p_last), f(a_last);
  }
};

// What the sums over neighbours and the solves leave at each particle.
template <class T>
struct SphSums {
  Field<T, 1> rho0, rho;      // rest density, density [kg/m3]
  Field<T, 1> V;              // m / rho [m3]
  Field<T, 1> lam, G;         // Lame's moduli, hardened [Pa]
  Field<T, 9> L, P;           // correction of the kernel's gradient, and how much of it there is [1]
  Field<T, 3> around, walls;  // sums of V_j grad W_ij over snow, and over boundaries [1/m]
  Field<T, 3> loose, held;    // of the latter, of solids that snow may leave; those that shear acts on [1/m]
  Field<T, 1> squares;        // V_i sum V_j |grad W_ij|^2 over snow [1/m2]
  Field<T, 3> given;          // acceleration by gravity and friction [m/s2]
  Field<T, 1> inflow;         // sum V_b v_b . grad W_ib [1/s]
  Field<T, 1> fill;           // of water: how much of its kernel is filled [1]
  Field<T, 1> share;          // of what V is, what a particle takes up beside the other phase [1]
  Field<T, 3> beside;         // sum of V_j grad W_ij over the other phase, by both shares [1/m]
  Field<T, 1> touch;   // 1 where the trace of the stress of shear acts on water, 0 where it would pull [1]
  Field<T, 1> across;  // sum V_j (u_j - u_i) . grad W_ij over the other phase, likewise [1/s for a velocity]
  Field<T, 1> p, p_next;         // pressure, two buffers [Pa]
  Field<T, 3> pressed, sheared;  // accelerations by pressure and by shear [m/s2]
  Field<T, 6> s;                 // stress of shear at the end of the step: xx yy zz xy xz yz [Pa]
  Column<Quartet<T>> quads,
      row;  // what pair sums gather of each particle: a vector, and the columns of a matrix

  void resize(std::size_t n) {
    if (rho.size() == n && quads.size() == n) return;
    each_field([&](auto& field) { field.resize(n); });
    quads.resize(n), row.resize(3 * n);
  }
  std::size_t bytes() {
    std::size_t sum = 4 * quads.size() * sizeof(Quartet<T>);
    each_field([&](auto& field) { sum += field.bytes(); });
    return sum;
  }

 private:
  template <class F>
  void each_field(F&& f) {
    f(rho0), f(rho), f(V), f(lam), f(G), f(L), f(P), f(around), f(walls), f(loose), f(held), f(squares),
        f(given), f(inflow), f(fill), f(share), f(beside), f(touch), f(across);
    f(p), f(p_next), f(pressed), f(sheared), f(s);
  }
};

}  // namespace neve
