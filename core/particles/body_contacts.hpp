// Contacts of particles with bodies: kept until it is known how the bodies move, which is found with what they do.
#pragma once

#include "coupling/body_solver.hpp"
#include "particles/solid_contacts.hpp"

namespace neve {

// Particles that may touch bodies in this step.
template <class T>
struct ContactPack {
  using R = Lanes<T>;
  std::size_t p;  // first particle
  int count;
  Vec3<R> x, v, out;  // v: after all but the bodies; out: what solids set them out [m]
  R r, m;
  std::size_t begin, end;  // of its contacts
};

// Those of one chunk. P: a ContactPack, or what holds more.
template <class T, class P = ContactPack<T>>
struct BodyContacts {
  std::vector<P> packs;
  std::vector<SolidContact<Lanes<T>>> contacts;
};

namespace detail {

// Let the bodies, which move with U, act on a pack one after another; call visit(contact, v_co, v before, v after) for each.
// Returns the velocities after.
template <class T, class P, class F>
Vec3<Lanes<T>> touch_bodies(const BodyContacts<T, P>& all, const ContactPack<T>& pack,
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

// What the snow does to one body, from some packs.
template <class T>
struct BodyPart {
  ImpulseOf<Doubles<Lanes<T>>> impulse;
  SlopeOf<Lanes<T>> slope;
};

template <class T>
void add_impulse(BodyPart<T>& sum, const SolidContact<Lanes<T>>& contact, const Lanes<T>& m,
                 const Vec3<Lanes<T>>& v_co, const Vec3<Lanes<T>>& before, const Vec3<Lanes<T>>& after) {
  const auto met = contact.met(before, v_co);
  if (any(met))
    neve::add_impulse(sum.impulse, met, m, contact.arm, contact.sped(before), contact.sped(after));
}

template <class T>
void add_slope(BodyPart<T>& sum, const SolidContact<Lanes<T>>& contact, const Lanes<T>& m,
               const Vec3<Lanes<T>>& v_co, const Vec3<Lanes<T>>& before) {
  const auto met = contact.met(before, v_co), dry = met & negated(contact.runs);
  if (!any(met)) return;
  const Vec3<Lanes<T>> from = contact.sped(before);
  Solid<T> surface = *contact.solid;
  const auto add = [&](const auto& lanes, ContactMode mode, T mu_c) {
    if (!any(lanes)) return;
    surface.mode = mode, surface.mu_c = mu_c;
    neve::add_slope(sum.slope, surface, lanes, m, contact.n, contact.arm, {}, v_co, from);
  };
  const T mu_c = contact.solid->mu_c;
  add(dry & contact.held, contact.mode(), mu_c);
  add(dry & negated(contact.held), ContactMode::separate, mu_c);
  add(met & contact.runs, ContactMode::separate, T(0));
}

}  // namespace detail

// The velocities of the bodies after a step of dt [s], found together with those of the particles that touch them; none
// if nothing does. Sums are made chunk by chunk, then in the order of the chunks, whatever the threads do.
template <class T, class P>
std::vector<Twist> body_velocities(const CoupledBodies& bodies,
                                   const std::vector<const BodyContacts<T, P>*>& chunks, double dt) {
  std::vector<const BodyContacts<T, P>*> busy;
  for (const auto* chunk : chunks) {
    if (!chunk->packs.empty()) busy.push_back(chunk);
  }
  if (busy.empty()) return {};
  const std::size_t count = bodies.solids.size();
  std::vector<std::vector<detail::BodyPart<T>>> parts(busy.size());
  const auto respond = [&](const std::vector<Twist>& U, bool slopes) {
    each_index(busy.size(), [&](std::size_t c) {
      parts[c].assign(count, {});
      for (const auto& pack : busy[c]->packs) {
        detail::touch_bodies(
            *busy[c], pack, U,
            [&](const auto& contact, const auto& v_co, const auto& before, const auto& after) {
              detail::BodyPart<T>& sum = parts[c][std::size_t(contact.solid->body)];
              if (slopes)
                detail::add_slope(sum, contact, pack.m, v_co, before);
              else
                detail::add_impulse(sum, contact, pack.m, v_co, before, after);
            });
      }
    });
    std::vector<BodyResponse> total(count);
    for (const auto& part : parts) {
      for (std::size_t b = 0; b < count; ++b) {
        for (int k = 0; k < 6; ++k) total[b].impulse[k] += sum_lanes(part[b].impulse.impulse[k]);
        for (int k = 0; slopes && k < 36; ++k) total[b].slope[k] += double(sum_lanes(part[b].slope.slope[k]));
      }
    }
    return total;
  };
  return BodyVelocitySolver(bodies, dt).solve(respond);
}

}  // namespace neve
