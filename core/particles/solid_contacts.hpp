// Contact of particles with several solids at once.
#pragma once

#include <vector>

#include "particles/solid_contact.hpp"

namespace neve {

// What one solid, whose surface moves with v_co, did to the velocities of a pack.
template <class R>
struct ContactChange {
  Vec3<R> v_co, before, after;
};

// The solids that a pack may meet. They act one after another. That adds no energy if, over all of them, the impulses J
// do no work on the particle as it moves in the end against the solids: sum J . (v_end - v_co) <= 0, which one solid
// alone never violates. A floor that stops what a paddle then moves on does: its impulse then counts for a particle at
// rest. Such particles meet the solids in the reverse order; if that is wrong too, only the last of them.
template <class R>
class SolidContacts {
 public:
  using T = scalar_t<R>;
  using Mask = typename SolidContact<R>::Mask;
  std::vector<SolidContact<R>> contacts;
  std::vector<ContactChange<R>> changes;  // by contact

  // The velocities after all solids have acted on those that move with v.
  Vec3<R> act(const Vec3<R>& v, T dt) {
    const int last = int(contacts.size()) - 1;
    changes.resize(contacts.size());
    Vec3<R> end = v;
    for (int e = 0; e <= last; ++e) end = meet(e, splat<R>(0) < splat<R>(1), end, dt);
    if (last < 1) return end;
    Mask wrong = gains(end);
    if (!any(wrong)) return end;
    Vec3<R> turned = v;
    for (int e = last; e >= 0; --e) turned = meet(e, wrong, turned, dt);
    end = select(wrong, turned, end);
    wrong = gains(end);
    if (!any(wrong)) return end;
    Vec3<R> alone = v;
    Mask open = wrong;
    for (int e = last; e >= 0; --e) {
      alone = meet(e, wrong, alone, dt, open);
      const ContactChange<R>& change = changes[std::size_t(e)];
      open = open & negated(contacts[std::size_t(e)].met(change.before, change.v_co));
    }
    return select(wrong, alone, end);
  }

 private:
  // Let solid e act on `lanes`, of them only on those that are `open` to it; the changes of other lanes stay.
  Vec3<R> meet(int e, const Mask& lanes, const Vec3<R>& v, T dt, const Mask& open) {
    const SolidContact<R>& contact = contacts[std::size_t(e)];
    ContactChange<R>& change = changes[std::size_t(e)];
    const Vec3<R> v_co = contact.solid->surface_velocity_at(contact.x, contact.n);
    Vec3<R> after = v;
    if (any(open & contact.met(v, v_co))) {
      const Vec3<R> v_rel = contact.sped(v) - v_co;
      const auto there = facing(*contact.solid, contact.x, contact.n, v_rel, splat<R>(dt), contact.here);
      after = select(open, contact.after(v, there, v_co), v);
    }
    change.v_co = v_co;
    change.before = select(lanes, v, change.before);
    change.after = select(lanes, after, change.after);
    return after;
  }
  Vec3<R> meet(int e, const Mask& lanes, const Vec3<R>& v, T dt) { return meet(e, lanes, v, dt, lanes); }

  // Where impulses do work on particles that leave with `end`, beyond rounding.
  Mask gains(const Vec3<R>& end) const {
    R work = splat<R>(0), scale = splat<R>(0);
    for (const ContactChange<R>& change : changes) {
      const Vec3<R> dv = change.after - change.before;
      work += dot(dv, end - change.v_co);
      scale += sqrt(R(dot(dv, dv) * (dot(end, end) + dot(change.v_co, change.v_co))));
    }
    return work > scale * T(1e-5);
  }
};

}  // namespace neve
