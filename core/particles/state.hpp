// Particles of the discrete element method: everything per particle, as a structure of arrays.
#pragma once

#include "mpm/state.hpp"

namespace neve {

// What a material is to particles in contact (docs/particles.md).
struct ContactMaterial {
  double modulus;      // of contact: a contact of particles of radius r has the stiffness modulus r [Pa]
  double friction;     // Coulomb's coefficient [1]
  double bond_strain;  // stretch over the distance of two particles at which their bond breaks [1]
  double yield;        // pressure of opposing forces at which a particle is compacted, at birth [Pa]
};

template <class T>
struct ParticleState {
  std::size_t count = 0;
  Field<T, 3> x, v;         // position [m], velocity [m/s]
  Field<T, 1> m, V0;        // mass [kg], volume of snow at birth [m3]
  Field<T, 1> radius;       // now [m]
  Field<T, 1> J_P;          // volume over that at birth [1]
  Field<T, 1> stiffness;    // factor on the modulus [1]
  Field<T, 1> strength;     // factor on bond_strain and yield [1]
  Field<T, 1> liquid;       // share of the mass that is water, as size and strength follow it [1]
  Column<double> enthalpy;  // zero for ice at the melting point [J]
  Column<std::uint16_t> material, source;  // rows of the material table and of the scene's sources
  Column<std::uint32_t> id;                // birth number

  // What follows from these and the material table, see derive().
  Field<T, 1> k;      // modulus times radius at birth [N/m]
  Field<T, 1> mu;     // friction [1]
  Field<T, 1> bond;   // bond_strain times strength [1]
  Field<T, 1> yield;  // [Pa]

  template <class F>
  void each_column(F&& f) {
    each_field([&](auto& field) {
      for (int i = 0; i < field.components(); ++i) f(field.column(i));
    });
    f(enthalpy.data()), f(material.data()), f(source.data()), f(id.data());
  }

  void resize(std::size_t n) {
    each_field([&](auto& field) { field.resize(n); });
    enthalpy.resize(n), material.resize(n), source.resize(n), id.resize(n);
    for (std::size_t p = count; p < n; ++p) {
      J_P.column(0)[p] = stiffness.column(0)[p] = strength.column(0)[p] = T(1);
      id[p] = static_cast<std::uint32_t>(p);
    }
    count = n;
  }

  std::size_t bytes() {
    std::size_t sum = count * (sizeof(double) + 2 * sizeof(std::uint16_t) + sizeof(std::uint32_t));
    each_field([&](auto& field) { sum += field.bytes(); });
    return sum;
  }

 private:
  template <class F>
  void each_field(F&& f) {
    f(x), f(v), f(m), f(V0), f(radius), f(J_P), f(stiffness), f(strength), f(liquid), f(k), f(mu), f(bond),
        f(yield);
  }
};

// Stiffness of water's contacts over that of the snow it was [1].
inline constexpr double soft = 0.1;

// Fill the columns of particle p that follow from others. The stiffness of contacts stays while a particle is compacted: its
// modulus rises as its radius falls. With the liquid share it falls, and strength and friction go.
template <class T>
void derive(ParticleState<T>& s, const std::vector<ContactMaterial>& table, std::size_t p) {
  const ContactMaterial& material = table[s.material[p]];
  const double wet = s.liquid.column(0)[p], strength = double(s.strength.column(0)[p]) * (1 - wet);
  const double at_birth = double(s.radius.column(0)[p]) / std::cbrt(double(s.J_P.column(0)[p]));
  const double stiffness = double(s.stiffness.column(0)[p]) * (1 - wet * (1 - soft));
  s.k.column(0)[p] = T(material.modulus * stiffness * at_birth);
  s.mu.column(0)[p] = T(material.friction * (1 - wet));
  s.bond.column(0)[p] = T(material.bond_strain * strength);
  s.yield.column(0)[p] = T(material.yield * strength);
}
template <class T>
void derive(ParticleState<T>& s, const std::vector<ContactMaterial>& table) {
  for (std::size_t p = 0; p < s.count; ++p) derive(s, table, p);
}

}  // namespace neve
