// Snow as smoothed particles (Gissler et al. 2020): what a particle owns, and what a step finds of it.
#pragma once

#include "mpm/state.hpp"
#include "neighbours/gather.hpp"
#include "sph/kernel.hpp"

namespace neve {

template <class T>
struct SphState {
  std::size_t count = 0;
  Field<T, 3> x, v;                        // position [m], velocity [m/s]
  Field<T, 9> F_E;                         // elastic deformation gradient, symmetric [1]
  Field<T, 1> m, V0;                       // mass [kg], volume at birth [m3]
  Field<T, 1> rho_birth;                   // rest density at birth; 0: it is not known yet [kg/m3]
  Field<T, 1> J_P;                         // that over the rest density now [1]
  Field<T, 1> stiffness, strength;         // factors on E0 and on the critical strains [1]
  Column<std::uint16_t> material, source;  // rows of the material table and of the scene's sources
  Column<std::uint32_t> id;                // birth number

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
    f(x), f(v), f(F_E), f(m), f(V0), f(rho_birth), f(J_P), f(stiffness), f(strength);
  }
};

// What the sums over neighbours and the solves leave at each particle.
template <class T>
struct SphSums {
  Field<T, 1> rho0, rho;             // rest density, density [kg/m3]
  Field<T, 1> V;                     // m / rho [m3]
  Field<T, 1> lam, G;                // Lame's moduli, hardened [Pa]
  Field<T, 9> L;                     // correction of the kernel's gradient [1]
  Field<T, 3> around, walls;         // sums of V_j grad W_ij over snow, and over boundaries [1/m]
  Field<T, 3> loose;                 // of the latter, of solids that snow may leave [1/m]
  Field<T, 1> squares;               // V_i sum V_j |grad W_ij|^2 over snow [1/m2]
  Field<T, 3> given;                 // acceleration by gravity and friction [m/s2]
  Field<T, 1> inflow;                // sum V_b v_b . grad W_ib [1/s]
  Field<T, 1> p, p_next;             // pressure, two buffers [Pa]
  Field<T, 3> pressed, sheared;      // accelerations by pressure and by shear [m/s2]
  Field<T, 6> s;                     // stress of shear at the end of the step: xx yy zz xy xz yz [Pa]
  Column<Quartet<T>> quads, row[3];  // what pair sums gather: a vector and a number of each particle

  void resize(std::size_t n) {
    if (rho.size() == n && quads.size() == n) return;
    each_field([&](auto& field) { field.resize(n); });
    quads.resize(n);
    for (auto& column : row) column.resize(n);
  }
  std::size_t bytes() {
    std::size_t sum = 4 * quads.size() * sizeof(Quartet<T>);
    each_field([&](auto& field) { sum += field.bytes(); });
    return sum;
  }

 private:
  template <class F>
  void each_field(F&& f) {
    f(rho0), f(rho), f(V), f(lam), f(G), f(L), f(around), f(walls), f(loose), f(squares), f(given), f(inflow);
    f(p), f(p_next), f(pressed), f(sheared), f(s);
  }
};

}  // namespace neve
