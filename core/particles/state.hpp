// Particles of the discrete element method: everything per particle, as a structure of arrays.
#pragma once

#include <cmath>
#include <vector>

#include "heat/enthalpy.hpp"
#include "mpm/state.hpp"
#include "neighbours/start_grid.hpp"
#include "threads.hpp"

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
  Field<T, 3> x, v;       // position [m], velocity [m/s]
  Field<T, 1> m, V0;      // mass [kg], volume of snow at birth [m3]
  Field<T, 1> radius;     // now [m]
  Field<T, 1> J_P;        // volume over that at birth [1]
  Field<T, 1> stiffness;  // factor on the modulus [1]
  Field<T, 1> strength;   // factor on bond_strain and yield [1]
  Field<T, 1> liquid;     // share of the mass that is water, as size and strength follow it [1]
  Field<T, 4>
      rest;  // how long it has stayed near a place [s], and the place [m]; in sleep infinite, and the force on it [N]
  Column<double> enthalpy;                 // zero for ice at the melting point [J]
  Column<std::uint16_t> material, source;  // rows of the material table and of the scene's sources
  Column<std::uint32_t> id;                // birth number

  // What follows from these and the material table, see derive().
  Field<T, 1> k;        // modulus times radius at birth [N/m]
  Field<T, 1> mu;       // friction [1]
  Field<T, 1> bond;     // stretch over the radii's sum at which bonds break [1]
  Field<T, 1> yield;    // [Pa]
  Field<T, 1> born;     // radius at birth [m]
  Field<T, 1> born_of;  // volume from which that was found [m3]

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
    f(x), f(v), f(m), f(V0), f(radius), f(J_P), f(stiffness), f(strength), f(liquid), f(rest), f(k), f(mu),
        f(bond), f(yield), f(born), f(born_of);
  }
};

namespace detail {

// Distance of particles p and q [m].
template <class T>
double distance(const ParticleState<T>& s, std::size_t p, std::size_t q) {
  double d2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = double(s.x.column(k)[p]) - double(s.x.column(k)[q]);
    d2 += d * d;
  }
  return std::sqrt(d2);
}

}  // namespace detail

// Stiffness of water's contacts over that of the snow it was [1].
inline constexpr double soft = 0.1;

// Bounds of what follows from the columns of the particles.
struct ConstantBounds {
  double stiffest = 0;  // largest k / m of a particle [1/s2]
  double radius = 0;    // largest at birth [m]
  void merge(const ConstantBounds& o) {
    stiffest = std::max(stiffest, o.stiffest), radius = std::max(radius, o.radius);
  }
};

// Cohesive strength [Pa] of snow of density rho [kg/m3]: 625 at 100, 3750 at 900, as in a port of Goswami et al. 2019.
inline double cohesive_strength(double rho) { return 625 + 3125 * (rho - 100) / 800; }

// Forces at which bonds break grow in steps of this share of that at birth: then those that are there have to grow along seldom.
inline constexpr double growth_step = 0.01;

// The force that breaks a bond of snow of density `born` [kg/m3] at birth, once its particles have `size` times the radius, over that at
// birth: cohesive strength over the area of a particle.
inline double bond_growth(double born, double size) {
  const double stronger = cohesive_strength(born / (size * size * size)) / cohesive_strength(born);
  return growth_step * std::floor(stronger * size * size / growth_step + 0.25);
}

// Radius over that at birth of what is solid of particle p.
template <class T>
double solid_size(const ParticleState<T>& s, std::size_t p) {
  const double V0 = s.V0.column(0)[p], J = s.J_P.column(0)[p], wet = s.liquid.column(0)[p];
  if (!(V0 > 0 && J < 1)) return 1;
  if (wet > 0) return std::cbrt(heat::solid_ratio(J, wet, double(s.m.column(0)[p]) / V0));
  return double(s.radius.column(0)[p]) / double(s.born.column(0)[p]);
}

// Stretch over the radii's sum at birth at which bonds of particle p break, as compaction and melting have made it [1].
template <class T>
double strength_of(const ParticleState<T>& s, const std::vector<ContactMaterial>& table, std::size_t p) {
  const double born = double(s.m.column(0)[p]) / std::max(double(s.V0.column(0)[p]), 1e-300);
  return table[s.material[p]].bond_strain * double(s.strength.column(0)[p]) *
         (1 - double(s.liquid.column(0)[p])) * bond_growth(born, solid_size(s, p));
}

// Fill the columns of particle p that follow from others. The stiffness of contacts stays while a particle is compacted: its
// modulus rises as its radius falls, its bonds gain strength. With the liquid share stiffness falls, and strength and friction go.
template <class T>
void derive(ParticleState<T>& s, const std::vector<ContactMaterial>& table, std::size_t p) {
  const ContactMaterial& material = table[s.material[p]];
  const double wet = s.liquid.column(0)[p], strength = double(s.strength.column(0)[p]) * (1 - wet);
  const double stiffness = double(s.stiffness.column(0)[p]) * (1 - wet * (1 - soft));
  s.k.column(0)[p] = T(material.modulus * stiffness * double(s.born.column(0)[p]));
  s.mu.column(0)[p] = T(material.friction * (1 - wet));
  s.bond.column(0)[p] = T(strength_of(s, table, p) / solid_size(s, p));
  s.yield.column(0)[p] = T(material.yield * strength);
}
// All particles; spheres of the radii at birth fill the share `packing` of the volumes.
template <class T>
ConstantBounds derive(ParticleState<T>& s, const std::vector<ContactMaterial>& table, double packing) {
  std::vector<ConstantBounds> parts(static_cast<std::size_t>(thread_count()));
  each_chunk(s.count, [&](int chunk, std::size_t begin, std::size_t end) {
    ConstantBounds mine;
    for (std::size_t p = begin; p < end; ++p) {
      const T V0 = s.V0.column(0)[p];
      if (s.born_of.column(0)[p] != V0) {
        s.born_of.column(0)[p] = V0;
        s.born.column(0)[p] = T(std::cbrt(packing * double(V0) * 0.75 / 3.14159265358979));
      }
      derive(s, table, p);
      mine.merge({double(s.k.column(0)[p]) / double(s.m.column(0)[p]), double(s.born.column(0)[p])});
    }
    parts[std::size_t(chunk)] = mine;
  });
  ConstantBounds out;
  for (const ConstantBounds& part : parts) out.merge(part);
  return out;
}

// What the forces of pairs need of particles, by rows. place: x, y, z [m], radius [m]. motion: velocity [m/s], and stiffness [N/m], below zero for a particle that sleeps. grip:
// friction [1], bond strain [1], liquid share [1], mass [kg]. One row more than there are particles, and what fills its group, are near nothing.
template <class T>
struct PairQuads {
  Column<Quartet<T>> place, motion, grip;

  static constexpr std::size_t room_for(std::size_t n) { return n + 1 + std::size_t(lane_count<T>); }
  bool made_for(std::size_t n) const { return place.size() == room_for(n); }
  void resize(std::size_t n) {
    const std::size_t room = room_for(n);
    if (place.size() != room) place.resize(room), motion.resize(room), grip.resize(room);
    constexpr T far = StartGrid<T>::nowhere;
    for (std::size_t p = n; p < room; ++p) place[p] = {far, far, far, T(0)}, motion[p] = grip[p] = {};
  }
  // Read particle p.
  void set(const ParticleState<T>& s, std::size_t p, bool asleep) {
    const T k = s.k.column(0)[p];
    place[p] = {s.x.column(0)[p], s.x.column(1)[p], s.x.column(2)[p], s.radius.column(0)[p]};
    motion[p] = {s.v.column(0)[p], s.v.column(1)[p], s.v.column(2)[p], asleep ? -k : k};
    grip[p] = {s.mu.column(0)[p], s.bond.column(0)[p], s.liquid.column(0)[p], s.m.column(0)[p]};
  }
  bool asleep(std::size_t p) const { return motion[p].d < T(0); }
};

}  // namespace neve
