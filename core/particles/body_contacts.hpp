// Contacts of particles with bodies: kept until it is known how the bodies move, which is found with what they do.
#pragma once

#include "coupling/body_solver.hpp"
#include "particles/solid_contacts.hpp"
#include "particles/step.hpp"

namespace neve {

// Particles of one chunk that may touch bodies in this step.
template <class T>
struct BodyContacts {
  using R = Lanes<T>;
  struct Pack {
    std::size_t p;  // first particle
    int count;
    Vec3<R> x, v, out;  // v: after all but the bodies; out: what solids set them out [m]
    R r, m;
    std::array<R, PairSums<T>::count> sums;
    std::size_t begin, end;  // of its contacts
  };
  std::vector<Pack> packs;
  std::vector<SolidContact<R>> contacts;
};

namespace detail {

// Let the bodies, which move with U, act on a pack one after another; call visit(contact, v_co, v before, v after) for each.
// Returns the velocities after.
template <class T, class F>
Vec3<Lanes<T>> touch_bodies(const BodyContacts<T>& all, const typename BodyContacts<T>::Pack& pack,
                            const std::vector<Twist>& U, F&& visit) {
  Vec3<Lanes<T>> v = pack.v;
  for (std::size_t e = pack.begin; e < pack.end; ++e) {
    const auto& contact = all.contacts[e];
    const auto v_co = surface_velocity(*contact.solid, U.front().data(), contact.arm, contact.n);
    const auto before = v;
    v = contact.after(v, flat(contact.n), v_co);
    visit(contact, v_co, before, v);
  }
  return v;
}

template <class T>
void add_to_response(ResponseOf<Doubles<Lanes<T>>>& sum, const SolidContact<Lanes<T>>& contact,
                     const Lanes<T>& m, const Vec3<Lanes<T>>& v_co, const Vec3<Lanes<T>>& before,
                     const Vec3<Lanes<T>>& after) {
  const auto met = contact.met(before, v_co), dry = met & negated(contact.runs);
  const Vec3<Lanes<T>> from = contact.sped(before), to = contact.sped(after);
  Solid<T> solid = *contact.solid;
  solid.mode = contact.mode();
  add_response(sum, solid, dry & contact.held, m, contact.n, contact.arm, {}, v_co, from, to);
  solid.mode = ContactMode::separate;
  add_response(sum, solid, dry & negated(contact.held), m, contact.n, contact.arm, {}, v_co, from, to);
  solid.mu_c = 0;
  add_response(sum, solid, met & contact.runs, m, contact.n, contact.arm, {}, v_co, from, to);
}

}  // namespace detail

// The velocities of the bodies after a step of dt [s], found together with those of the particles that touch them; none
// if nothing does. Sums are made chunk by chunk, then in the order of the chunks, whatever the threads do.
template <class T>
std::vector<Twist> body_velocities(const CoupledBodies& bodies,
                                   const std::vector<const BodyContacts<T>*>& chunks, double dt) {
  std::vector<const BodyContacts<T>*> busy;
  for (const auto* chunk : chunks) {
    if (!chunk->packs.empty()) busy.push_back(chunk);
  }
  if (busy.empty()) return {};
  const std::size_t count = bodies.solids.size();
  using Part = ResponseOf<Doubles<Lanes<T>>>;
  std::vector<std::vector<Part>> parts(busy.size());
  return BodyVelocitySolver(bodies, dt).solve([&](const std::vector<Twist>& U) {
    each_index(busy.size(), [&](std::size_t c) {
      parts[c].assign(count, Part{});
      for (const auto& pack : busy[c]->packs) {
        detail::touch_bodies(*busy[c], pack, U, [&](const auto& contact, const auto&... velocities) {
          detail::add_to_response<T>(parts[c][std::size_t(contact.solid->body)], contact, pack.m,
                                     velocities...);
        });
      }
    });
    std::vector<BodyResponse> total(count);
    for (const auto& part : parts) {
      for (std::size_t b = 0; b < count; ++b) total[b].add(detail::summed(part[b]));
    }
    return total;
  });
}

}  // namespace neve
