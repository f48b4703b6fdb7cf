// Whether a solution of an implicit step is good enough.
//
// It is if on each piece of snow the impulses that are left over, |r| = sqrt(sum |r_i|^2 / m_i), are less than `tolerance` of
// the largest of those of gravity, of stress, and of what was left over at the start; and on each group of bodies, in the
// norm of the velocities that they would give it and the snow on its skin, less than that of what changes its motion
// without the snow, of its impulses, and of gravity and stress on that skin. The test has no unit. Nor need they be smaller than
// what a few roundings of the particles' F and of the momenta make of them: snow that nothing loads has no other scale, and
// the strains of stiff snow in float32 are a few roundings.
#pragma once

#include "cpu/implicit/krylov.hpp"
#include "cpu/implicit/nodes/body_contacts.hpp"

namespace neve {

template <class T>
class StoppingTest {
 public:
  // Find the pieces of snow: what a group of bodies touches is one.
  void find(const Grid<T>& grid, const BodyUnknowns& bodies, const BodyContacts<T>& contacts) {
    std::vector<std::pair<std::int32_t, std::int32_t>> joined;
    const auto met = contacts.met_bodies();
    block_of_group_.clear();
    for (const auto& group : bodies.groups()) {
      std::int32_t first = -1;
      for (const auto& [body, block] : met) {
        if (!std::binary_search(group.bodies.begin(), group.bodies.end(), body)) continue;
        if (first < 0) first = block;
        joined.emplace_back(first, block);
      }
      block_of_group_.push_back(std::size_t(first));
    }
    pieces_.find(grid, joined);
  }
  const Pieces& pieces() const { return pieces_; }
  std::size_t piece_of_group(std::size_t g) const { return pieces_.of(block_of_group_[g]); }

  // The scales: `fall`, dt g; `stress`, the impulses of stress; q of bodies that go on as before.
  void begin(const NodeField<T>& mass, const NodeField<T>& inverse, const T (&fall)[4],
             const NodeField<T>& stress, std::size_t blocks, const BodyUnknowns& bodies,
             const BodyContacts<T>& contacts, const std::vector<double>& q) {
    BlockSums parts;
    each_block_summed(parts, blocks, [&](std::size_t b) {
      const T* m = mass.block(b);
      return detail::block_sum(
          [&](int i) { return double(m[i]) * double(fall[i % 4]) * double(fall[i % 4]); });
    });
    scale2_ = pieces_.sums(parts);
    sum_squares(stress, inverse, blocks, parts);
    raise(scale2_, pieces_.sums(parts));
    begin_groups(mass, inverse, fall, stress, bodies, contacts);
    raise(group_scale2_, squares(bodies, q));
    rounding2_.assign(blocks, 0.0);
  }

  // From now on leave alone in each block some times `rounding`, of the particles, and that of the momenta at the velocities v.
  void allow(const Unknowns<T>& rounding, const NodeField<T>& v, const NodeField<T>& mass,
             const NodeField<T>& inverse, std::size_t blocks, const BodyUnknowns& bodies, double tolerance) {
    constexpr double most = roundings * roundings, unit = 0.5 * double(std::numeric_limits<T>::epsilon());
    BlockSums parts;
    sum_squares(rounding.nodes, inverse, blocks, parts);
    raise(rounding2_, parts, most);
    sum_squares(v, mass, blocks, parts);
    raise(rounding2_, parts, most * unit * unit);
    raise(group_scale2_, squares(bodies, bodies.halfway(rounding.bodies)), most / (tolerance * tolerance));
  }

  // The largest residual over its scale; `raises`: none may be more than all, which is what was left over at the start.
  double worst(const Unknowns<T>& r, const NodeField<T>& inverse, std::size_t blocks,
               const BodyUnknowns& bodies, const std::vector<double>& q, bool raises) {
    BlockSums parts;
    sum_squares(r.nodes, inverse, blocks, parts);
    for (std::size_t b = 0; b < blocks; ++b) parts[b] -= std::min(parts[b], rounding2_[b]);
    const std::vector<double> sums = pieces_.sums(parts);
    const std::vector<double> groups = squares(bodies, bodies.halfway(r.bodies));
    raise(group_scale2_, squares(bodies, q));
    if (raises) raise(scale2_, sums), raise(group_scale2_, groups);
    return std::sqrt(std::max(most(sums, scale2_), most(groups, group_scale2_)));
  }

 private:
  static constexpr double roundings = 3;  // that are left alone

  static void raise(std::vector<double>& scale2, const std::vector<double>& sums, double times = 1) {
    for (std::size_t c = 0; c < sums.size(); ++c) scale2[c] = std::max(scale2[c], times * sums[c]);
  }
  static double most(const std::vector<double>& sums, const std::vector<double>& scale2) {
    double found = 0;
    for (std::size_t c = 0; c < sums.size(); ++c) {
      if (!std::isfinite(sums[c])) return std::numeric_limits<double>::infinity();
      if (sums[c] > 0) found = std::max(found, sums[c] / scale2[c]);
    }
    return found;
  }
  static std::vector<double> squares(const BodyUnknowns& bodies, const std::vector<double>& q) {
    std::vector<double> out;
    for (const auto& group : bodies.groups()) {
      double sum = 0;
      for (std::size_t k = 0; k < group.rank; ++k) sum += q[group.first + k] * q[group.first + k];
      out.push_back(sum);
    }
    return out;
  }

  void begin_groups(const NodeField<T>& mass, const NodeField<T>& inverse, const T (&fall)[4],
                    const NodeField<T>& stress, const BodyUnknowns& bodies, const BodyContacts<T>& contacts) {
    const double g2 = double(fall[0]) * double(fall[0]) + double(fall[1]) * double(fall[1]) +
                      double(fall[2]) * double(fall[2]);
    group_scale2_.assign(bodies.groups().size(), 0.0);
    contacts.each_met([&](const ContactNode<T>& at, const NodeContact<T>& contact) {
      const Vec3<T> f = detail::vector_at(stress.node(at.block, at.node));
      const double all = double(mass.node(at.block, at.node)[0]) * g2 +
                         double(dot(f, f)) * double(inverse.node(at.block, at.node)[0]);
      for (std::size_t g = 0; g < group_scale2_.size(); ++g) {
        const auto& of = bodies.groups()[g].bodies;
        if (std::binary_search(of.begin(), of.end(), std::size_t(contact.solid->body)))
          group_scale2_[g] += all;
      }
    });
  }

  Pieces pieces_;
  std::vector<double> scale2_, group_scale2_, rounding2_;
  std::vector<std::size_t> block_of_group_;
};

}  // namespace neve
