// One node of an implicit step and the surfaces that may hold it: along which axes they give its velocity, and which of them
// gives how much of an impulse.
#pragma once

#include <vector>

#include "coupling/body_response.hpp"
#include "coupling/coupled_bodies.hpp"

namespace neve {

namespace detail {

template <class T>
Vec3<T> vector_at(const T* quad) {
  return {quad[0], quad[1], quad[2]};
}
template <class T>
void put(T* quad, const Vec3<T>& a) {
  quad[0] = a.x, quad[1] = a.y, quad[2] = a.z;
}

}  // namespace detail

// What a solid is to a node.
template <class T>
struct NodeContact {
  const Solid<T>* solid;
  Vec3<T> n, v_co, arm;
  bool holds;
  T drag = T(0), rub = T(0);  // [kg], mu_c lambda [N s]
  Vec3<T> t{};                // the direction of sliding; none where snow sticks
  Vec3<T> dv{};               // of a body: how much v_co changes in the product that is being made

  Vec3<T> along(const Vec3<T>& u) const { return u - n * dot(u, n); }
  // The friction at the velocity u; of a change of velocity u, its change.
  Vec3<T> friction(const Vec3<T>& u) const {
    const Vec3<T> slip = along(u - v_co);
    return (slip - t * dot(slip, t)) * drag + t * rub;
  }
  Vec3<T> friction_change(const Vec3<T>& u) const {
    const Vec3<T> slip = along(u - dv);
    return (slip - t * dot(slip, t)) * drag;
  }
  bool sticks() const { return holds && solid->mode == ContactMode::sticky; }
  bool is_of_body() const { return solid->body >= 0; }
  // How v_co changes if bodies change their velocities by dU.
  Vec3<T> change_by(const std::vector<Twist>& dU) const {
    if (!is_of_body()) return {};
    const double* u = dU[std::size_t(solid->body)].data();
    return linear<T>(u) + cross(angular<T>(u), arm);
  }
};

// A node and its contacts, of which `all` has those of all nodes. q: unit vectors along which its velocity is given.
template <class T>
struct ContactNode {
  using Contacts = std::vector<NodeContact<T>>;
  static constexpr double least_angle = 0.05;  // sine of that between a normal and those before it, to count

  std::size_t block;
  int node;
  std::size_t begin, end;
  int fixed = 0;
  Vec3<T> q[3]{};
  bool meets_body = false;

  // Find the q of the surfaces that hold.
  void find_frame(const Contacts& all) {
    fixed = 0;
    for (std::size_t c = begin; c < end && fixed < 3; ++c) {
      if (!all[c].holds) continue;
      if (all[c].sticks()) {
        for (int axis = 0; axis < 3 && fixed < 3; ++axis)
          add_direction({T(axis == 0), T(axis == 1), T(axis == 2)}, T(0.5));
      } else {
        add_direction(all[c].n, T(least_angle));
      }
    }
  }

  // u with the velocities along the q that surfaces of the velocities of(contact) give.
  template <class F>
  Vec3<T> held(const Contacts& all, Vec3<T> u, F&& of) const {
    int k = 0;
    for (std::size_t c = begin; c < end && k < fixed; ++c) {
      if (!all[c].holds) continue;
      const Vec3<T> v = of(all[c]);
      if (all[c].sticks()) {
        for (; k < 3; ++k) u = u + q[k] * dot(v - u, q[k]);
        break;
      }
      const T along = dot(all[c].n, q[k]);
      if (along > T(least_angle)) u = u + q[k++] * (dot(v - u, all[c].n) / along);
    }
    return u;
  }

  // What of u no surface gives.
  Vec3<T> freed(Vec3<T> u) const {
    if (fixed == 3) return {};
    for (int i = 0; i < fixed; ++i) u = u - q[i] * dot(u, q[i]);
    return u;
  }

  // What each holding surface gives of an impulse, friction left out: its push along its normal, and all that nothing has
  // pushed if snow sticks to it. `push`: the sizes of the pushes.
  void share(const Contacts& all, const Vec3<T>& impulse, std::vector<Vec3<T>>& given,
             std::vector<T>& push) const {
    given.assign(end - begin, Vec3<T>{});
    push.assign(end - begin, T(0));
    T left[3];
    std::size_t owner[3];
    int k = 0;
    std::size_t sticky = end;
    for (std::size_t c = begin; c < end && k < fixed && sticky == end; ++c) {
      if (all[c].sticks())
        sticky = c;
      else if (all[c].holds && dot(all[c].n, q[k]) > T(least_angle))
        owner[k] = c, ++k;
    }
    for (int i = 0; i < k; ++i) left[i] = dot(impulse, q[i]);
    Vec3<T> rest = impulse;
    for (int i = k - 1; i >= 0; --i) {
      const Vec3<T>& n = all[owner[i]].n;
      const T size = left[i] / dot(n, q[i]);
      push[owner[i] - begin] = size;
      given[owner[i] - begin] = n * size;
      rest = rest - n * size;
      for (int j = 0; j < i; ++j) left[j] -= size * dot(n, q[j]);
    }
    if (sticky < end) given[sticky - begin] = rest;
  }

 private:
  void add_direction(Vec3<T> a, T least) {
    for (int i = 0; i < fixed; ++i) a = a - q[i] * dot(a, q[i]);
    const T size = std::sqrt(dot(a, a));
    if (size > least) q[fixed++] = a * (T(1) / size);
  }
};

}  // namespace neve
