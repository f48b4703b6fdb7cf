// Bodies at the nodes of an implicit step: where a body holds snow the velocity of the node follows the body's, and what the
// node's equation leaves over is an impulse of the body; where it rubs, the drag is one of the difference of their velocities.
#pragma once

#include <array>
#include <utility>

#include "cpu/implicit/nodes/bodies.hpp"
#include "cpu/implicit/nodes/contacts.hpp"

namespace neve {

template <class T>
class BodyContacts : public ContactNodes<T> {
  using Node = ContactNode<T>;
  using Contact = NodeContact<T>;
  using ContactNodes<T>::nodes_, ContactNodes<T>::contacts_;

 public:
  // The bodies that some node may meet, each with the blocks where.
  std::vector<std::pair<std::size_t, std::int32_t>> met_bodies() const {
    std::vector<std::pair<std::size_t, std::int32_t>> out;
    each_met([&](const Node& at, const Contact& contact) {
      out.emplace_back(std::size_t(contact.solid->body), std::int32_t(at.block));
    });
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  // f(node, contact) for each contact of a node with a body.
  template <class F>
  void each_met(F&& f) const {
    for (const Node& at : nodes_) {
      for (std::size_t c = at.begin; at.meets_body && c < at.end; ++c) {
        if (contacts_[c].is_of_body()) f(at, contacts_[c]);
      }
    }
  }

  // Let the surfaces of bodies move as bodies do that move with U.
  void move_bodies(const std::vector<Twist>& U) {
    for (Contact& contact : contacts_) {
      if (contact.is_of_body())
        contact.v_co = surface_velocity(*contact.solid, U.front().data(), contact.arm, contact.n);
    }
  }

  // A change dU of the bodies' velocities: that of their surfaces, for friction_change, and of the nodes that they hold, in u.
  void carry(const std::vector<Twist>& dU, NodeField<T>& u) {
    for (const Node& at : nodes_) {
      if (!at.meets_body) continue;
      for (std::size_t c = at.begin; c < at.end; ++c) contacts_[c].dv = contacts_[c].change_by(dU);
      T* quad = u.node(at.block, at.node);
      detail::put(quad, at.held(contacts_, detail::vector_at(quad), [](const Contact& c) { return c.dv; }));
    }
  }

  // What the bodies give to the nodes, about their centres, of the impulses that the nodes need, friction among them: that
  // at the velocities v, or the change of it by changes v.
  std::vector<Twist> given(const NodeField<T>& impulses, const NodeField<T>& v, std::size_t bodies) {
    return given(impulses, v, bodies, [](const Contact& c, const Vec3<T>& u) { return c.friction(u); });
  }
  std::vector<Twist> change_given(const NodeField<T>& impulses, const NodeField<T>& v, std::size_t bodies) {
    return given(impulses, v, bodies,
                 [](const Contact& c, const Vec3<T>& u) { return c.friction_change(u); });
  }

  // The same without friction.
  std::vector<Twist> passed_on(const NodeField<T>& impulses, std::size_t bodies) {
    return given(impulses, impulses, bodies, [](const Contact&, const Vec3<T>&) { return Vec3<T>{}; });
  }

  // For each body K of the snow that moves with it: m where it holds, and where it rubs what is left of the drag as the node
  // yields, drag - drag^2 / (m + drag).
  std::vector<std::array<double, 36>> loads(const NodeField<T>& mass, const NodeField<T>& inverse,
                                            std::size_t bodies) const {
    std::vector<std::array<double, 36>> out(bodies);
    each_met([&](const Node& at, const Contact& contact) {
      const T m = mass.node(at.block, at.node)[0], one = inverse.node(at.block, at.node)[0];
      const T rubs = std::max(contact.drag - contact.drag * contact.drag * one, T(0));  // rounding aside
      add_load(at, contact, m, rubs, out[std::size_t(contact.solid->body)]);
    });
    return out;
  }

  // The drag between nodes and bodies in the preconditioner: what a residual r of the nodes gives to the bodies, and a change
  // dU of theirs to the nodes' z.
  std::vector<Twist> dragged(const NodeField<T>& r, const NodeField<T>& inverse, std::size_t bodies) const {
    std::vector<Twist> out(bodies);
    each_met([&](const Node& at, const Contact& contact) {
      const T share = contact.drag * inverse.node(at.block, at.node)[0];
      if (share > T(0)) add_impulse(contact, detail::vector_at(r.node(at.block, at.node)) * share, out);
    });
    return out;
  }
  void drag(const std::vector<Twist>& dU, const NodeField<T>& inverse, NodeField<T>& z) const {
    each_met([&](const Node& at, const Contact& contact) {
      const T share = contact.drag * inverse.node(at.block, at.node)[0];
      T* quad = z.node(at.block, at.node);
      if (share > T(0)) detail::put(quad, detail::vector_at(quad) + at.freed(contact.change_by(dU)) * share);
    });
  }

 private:
  template <class F>
  std::vector<Twist> given(const NodeField<T>& impulses, const NodeField<T>& v, std::size_t bodies,
                           F&& friction) {
    std::vector<Twist> out(bodies);
    for (const Node& at : nodes_) {
      if (!at.meets_body) continue;
      const Vec3<T> u = detail::vector_at(v.node(at.block, at.node));
      at.share(contacts_, detail::vector_at(impulses.node(at.block, at.node)), this->given_, this->push_);
      for (std::size_t c = at.begin; c < at.end; ++c) {
        const Contact& contact = contacts_[c];
        if (contact.is_of_body())
          add_impulse(contact, this->given_[c - at.begin] - friction(contact, u), out);
      }
    }
    return out;
  }

  static void add_impulse(const Contact& contact, const Vec3<T>& p, std::vector<Twist>& to) {
    Twist& sum = to[std::size_t(contact.solid->body)];
    const double a[3] = {contact.arm.x, contact.arm.y, contact.arm.z}, b[3] = {p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      sum[k] += b[k], sum[3 + k] += a[next] * b[last] - a[last] * b[next];
    }
  }

  void add_load(const Node& at, const Contact& contact, T m, T rubs, std::array<double, 36>& K) const {
    Vec3<T> holds[6], slips[6];
    for (int k = 0; k < 6; ++k) {
      const Vec3<T> e{T(k % 3 == 0), T(k % 3 == 1), T(k % 3 == 2)}, v = k < 3 ? e : cross(e, contact.arm);
      holds[k] =
          at.held(contacts_, Vec3<T>{}, [&](const Contact& c) { return &c == &contact ? v : Vec3<T>{}; });
      slips[k] = at.freed(v);
    }
    for (std::size_t k = 0; k < 36; ++k) {
      K[k] += double(m) * double(dot(holds[k / 6], holds[k % 6])) +
              double(rubs) * double(dot(slips[k / 6], slips[k % 6]));
    }
  }
};

}  // namespace neve
