// Solids at the nodes of an implicit step. A node that a solid holds keeps the velocities along its surface; what the solid
// must push with to hold it is what the solved equations leave over, and decides whether snow leaves and how much it rubs.
//
// Coulomb friction of the push lambda: where snow slides along t it is mu_c lambda t, and turns with t, by the drag
// mu_c lambda / |v_t| across t; where it sticks it is a drag in all directions, mu_c lambda at the slowest speed of sliding: a
// ten thousandth of a cell in a step, and no more than a thousandth of the largest speed, or of that of a fall by a cell, so
// that short steps have less of it. Which of them it is follows from the solution of the round before: snow that slides
// sticks when it would turn back, and slides when it is faster than the slowest speed. So does which surface holds.
#pragma once

#include "cpu/implicit/nodes/node_contact.hpp"
#include "cpu/implicit/nodes/nodes.hpp"
#include "cpu/near.hpp"
#include "mpm/node_update.hpp"

namespace neve {

inline constexpr double sticking_cells = 1e-4;  // that snow which sticks may creep in a step
inline constexpr double sticking_speed = 1e-3;  // of the largest speed

template <class T>
class ContactNodes {
 public:
  // Find the nodes that solids hold. In a step of dt [s], of nodes of the velocities v.
  void find(const Model<T>& model, const Grid<T>& grid, const NodeField<T>& mass, const NodeField<T>& v,
            double dt) {
    slowest_ = T(std::min(sticking_cells * model.dx / dt, sticking_speed * largest_speed(model, grid, v)));
    slowest_ = std::max(slowest_, T(1e-2 * sticking_cells * model.dx / dt));
    const SolidBalls<T> balls(model);
    std::vector<ContactNodes<T>> parts(model.solids.empty() ? 0 : grid.blocks.size());
    each_index(parts.size(), [&](std::size_t b) { parts[b].find_in(model, balls, grid.blocks[b], b, mass); });
    nodes_.clear(), contacts_.clear();
    for (const auto& part : parts) {
      for (ContactNode<T> node : part.nodes_) {
        node.begin += contacts_.size(), node.end += contacts_.size();
        nodes_.push_back(node);
      }
      contacts_.insert(contacts_.end(), part.contacts_.begin(), part.contacts_.end());
    }
  }

  // Begin from what the snow would do without solids: velocities v that were, and `free` at the end.
  void begin(const NodeField<T>& v, const NodeField<T>& free, const NodeField<T>& mass) {
    each_index(nodes_.size(), [&](std::size_t k) {
      ContactNode<T>& at = nodes_[k];
      const Vec3<T> was = detail::vector_at(v.node(at.block, at.node)),
                    will = detail::vector_at(free.node(at.block, at.node));
      for (std::size_t c = at.begin; c < at.end; ++c) {
        NodeContact<T>& contact = contacts_[c];
        const T gap = dot(will - contact.v_co, contact.n);
        contact.holds = contact.solid->mode != ContactMode::separate || gap < T(0);
        set_friction(contact, contact.along(was - contact.v_co), -gap * mass.node(at.block, at.node)[0]);
      }
      at.find_frame(contacts_);
    });
  }

  // Give the nodes that are held the velocities of the surfaces. Whether that changed any by more than rounding.
  bool fix(NodeField<T>& v) const {
    bool changed = false;
    for (const ContactNode<T>& at : nodes_) {
      T* quad = v.node(at.block, at.node);
      const Vec3<T> before = detail::vector_at(quad),
                    u = at.held(contacts_, before,
                                [](const NodeContact<T>& contact) { return contact.v_co; }),
                    moved = u - before;
      changed = changed || dot(moved, moved) > T(1e-6) * slowest_ * slowest_;
      detail::put(quad, u);
    }
    return changed;
  }

  // f(block, whether a body is among its solids) for each node that solids may hold.
  template <class F>
  void each_node(F&& f) const {
    for (const ContactNode<T>& at : nodes_) f(at.block, at.meets_body);
  }

  // Take from a vector on the nodes what lies along given velocities.
  void project(NodeField<T>& a) const {
    each_index(nodes_.size(), [&](std::size_t k) {
      const ContactNode<T>& at = nodes_[k];
      if (at.fixed == 0) return;
      T* quad = a.node(at.block, at.node);
      detail::put(quad, at.freed(detail::vector_at(quad)));
    });
  }

  // to += the friction at the velocities v.
  void add_friction(const NodeField<T>& v, NodeField<T>& to) const {
    add(v, to, [](const NodeContact<T>& contact, const Vec3<T>& u) { return contact.friction(u); });
  }
  // to += its change by changes of velocity.
  void add_friction_change(const NodeField<T>& v, NodeField<T>& to) const {
    add(v, to, [](const NodeContact<T>& contact, const Vec3<T>& u) { return contact.friction_change(u); });
  }
  // inverse = 1 / (mass + drag) at the nodes in contact.
  void add_to_inverse(const NodeField<T>& mass, NodeField<T>& inverse) const {
    for (const ContactNode<T>& at : nodes_) {
      T sum = mass.node(at.block, at.node)[0];
      for (std::size_t c = at.begin; c < at.end; ++c) sum += contacts_[c].drag;
      const T one = T(1) / sum;
      detail::put(inverse.node(at.block, at.node), Vec3<T>{one, one, one});
    }
  }

  // Follow a solution: v, and the impulses `left` that it needs of the solids. Whether all stayed as it was: the surfaces that
  // hold, and the sum of all friction to a hundredth.
  bool follow(const NodeField<T>& v, const NodeField<T>& left) {
    bool same = true;
    double change = 0, whole = 0;
    for (ContactNode<T>& at : nodes_) {
      const Vec3<T> u = detail::vector_at(v.node(at.block, at.node));
      at.share(contacts_, detail::vector_at(left.node(at.block, at.node)), given_, push_);
      bool turned = false;
      for (std::size_t c = at.begin; c < at.end; ++c) {
        NodeContact<T>& contact = contacts_[c];
        if (contact.solid->mode == ContactMode::sticky) continue;
        const T push = contact.holds ? push_[c - at.begin] : T(0);
        if (contact.solid->mode == ContactMode::separate) {
          const bool holds =
              contact.holds ? push >= T(0) : dot(u - contact.v_co, contact.n) < T(-1e-2) * slowest_;
          turned = turned || holds != contact.holds;
          contact.holds = holds;
        }
        const Vec3<T> before = contact.friction(u), slip = contact.along(u - contact.v_co);
        const bool slid = dot(contact.t, contact.t) > T(0), back = slid && dot(slip, contact.t) <= T(0);
        set_friction(contact, back ? Vec3<T>{} : slip, push);
        const Vec3<T> d = contact.friction(u) - before;
        change += std::sqrt(double(dot(d, d)));
        whole += double(contact.solid->mu_c) * std::max(double(push), 0.0);
      }
      if (turned) at.find_frame(contacts_);
      same = same && !turned;
    }
    return same && change <= 1e-2 * whole;
  }

  // Book what the solids gave to the snow: of the impulses `left` at the velocities v what lies along the surfaces' pushes,
  // and friction, taken `times` times; what is left over then is that of the surface that rubs most. Returns what the bodies
  // got of it.
  std::vector<Twist> exchange(const NodeField<T>& left, const NodeField<T>& v, std::size_t bodies, T times,
                              Grid<T>& grid) {
    std::vector<Twist> got(bodies);
    for (auto& sum : grid.node_exchange) sum.clear();
    for (const ContactNode<T>& at : nodes_) {
      const Vec3<T> u = detail::vector_at(v.node(at.block, at.node));
      Vec3<T> rest = detail::vector_at(left.node(at.block, at.node)), all = rest;
      for (std::size_t c = at.begin; c < at.end; ++c) all = all + contacts_[c].friction(u) * times;
      at.share(contacts_, all, given_, push_);
      std::size_t rubs = at.begin;
      for (std::size_t c = at.begin; c < at.end; ++c) {
        Vec3<T>& given = given_[c - at.begin];
        given = given - contacts_[c].friction(u) * times;
        rest = rest - given;
        if (contacts_[c].sticks() || contacts_[c].rub > contacts_[rubs].rub) rubs = c;
      }
      const bool takes = contacts_[rubs].holds && (contacts_[rubs].rub > T(0) || contacts_[rubs].sticks());
      if (takes) given_[rubs - at.begin] = given_[rubs - at.begin] + rest;
      for (std::size_t c = at.begin; c < at.end; ++c)
        book(contacts_[c], given_[c - at.begin], grid.node_exchange[at.block], got);
    }
    return got;
  }

 private:
  static void book(const NodeContact<T>& contact, const Vec3<T>& given, ExchangeSum& sums,
                   std::vector<Twist>& got) {
    if (!contact.holds) return;
    const double dp[3] = {given.x, given.y, given.z};
    const double arm[3] = {contact.arm.x, contact.arm.y, contact.arm.z};
    const double v_co[3] = {contact.v_co.x, contact.v_co.y, contact.v_co.z};
    Exchange now;
    record_impulse(now, dp, arm, v_co);
    sums.of(contact.solid->index).add(now);
    if (!contact.is_of_body()) return;
    Twist& body = got[std::size_t(contact.solid->body)];
    for (std::size_t k = 0; k < 3; ++k) body[k] += now.impulse[k], body[3 + k] += now.moment[k];
  }

  // Of nodes, solids, and a fall by a cell.
  static double largest_speed(const Model<T>& model, const Grid<T>& grid, const NodeField<T>& v) {
    BlockSums parts;
    each_block_summed(parts, grid.blocks.size(), [&](std::size_t b) {
      const T* u = v.block(b);
      return double(std::abs(
          *std::max_element(u, u + block_values, [](T a, T c) { return std::abs(a) < std::abs(c); })));
    });
    const Vec3<T>& g = model.gravity;
    double most = std::sqrt(std::sqrt(double(dot(g, g))) * model.dx);
    for (double each : parts) most = std::max(most, each);
    for (const auto& solid : model.solids)
      most = std::max(most, std::sqrt(double(dot(solid.velocity, solid.velocity))));
    return most;
  }

  void find_in(const Model<T>& model, const SolidBalls<T>& balls, BlockCoord where, std::size_t b,
               const NodeField<T>& mass) {
    const auto near = solids_near_block(model, balls, where);
    if (near.empty()) return;
    const T skin = T(skin_cells * model.dx);
    for (int n = 0; n < 64; ++n) {
      const T m = mass.node(b, n)[0];
      if (!(m > T(0))) continue;
      const Vec3<T> x = way_to_node(model, n);
      const std::size_t begin = contacts_.size();
      each_holding(near, x, m, skin, [&](const auto& solid, const Vec3<T>& normal, bool) {
        const Solid<T>& own = model.solids[std::size_t(solid.index)];
        contacts_.push_back(
            {&own, normal, solid.surface_velocity_at(x, normal), x - solid.centre, false, T(0)});
      });
      if (contacts_.size() == begin) continue;
      nodes_.push_back({b, n, begin, contacts_.size()});
      for (std::size_t c = begin; c < contacts_.size(); ++c)
        nodes_.back().meets_body = nodes_.back().meets_body || contacts_[c].is_of_body();
    }
  }

  template <class F>
  void add(const NodeField<T>& v, NodeField<T>& to, F&& f) const {
    each_index(nodes_.size(), [&](std::size_t k) {
      const ContactNode<T>& at = nodes_[k];
      const Vec3<T> u = detail::vector_at(v.node(at.block, at.node));
      T* quad = to.node(at.block, at.node);
      for (std::size_t c = at.begin; c < at.end; ++c) {
        if (contacts_[c].rub > T(0)) detail::put(quad, detail::vector_at(quad) + f(contacts_[c], u));
      }
    });
  }

  // Of snow that is pressed on with the impulse `push` and slides with `slip`; slower than the slowest, it sticks.
  void set_friction(NodeContact<T>& contact, const Vec3<T>& slip, T push) const {
    contact.rub = contact.drag = T(0), contact.t = {};
    if (!contact.holds || contact.solid->mode == ContactMode::sticky || !(push > T(0))) return;
    const T speed = std::sqrt(dot(slip, slip));
    contact.rub = contact.solid->mu_c * push;
    contact.drag = contact.rub / std::max(speed, slowest_);
    if (speed > slowest_) contact.t = slip * (T(1) / speed);
  }

  T slowest_ = T(0);

 protected:
  std::vector<ContactNode<T>> nodes_;
  std::vector<NodeContact<T>> contacts_;
  std::vector<T> push_;  // of one node, by its contacts; and what they give
  std::vector<Vec3<T>> given_;
};

}  // namespace neve
