// Which law moves which particle: the material table.
#pragma once

#include "constitutive/ice.hpp"
#include "constitutive/laws.hpp"
#include "cpu/wet.hpp"

namespace neve {

namespace detail {

// Put the identity into the lanes outside the mask: they then take no part in common decisions, on which the
// last bits of the other lanes depend.
template <class R, class M>
Mat3<R> quiet(const Mat3<R>& F, M mask) {
  return select(mask, F, identity<R>());
}

// The lanes of a pack that follow `law`, and one of their rows of the material table.
template <class T>
struct Followers {
  Lanes<T> mark{};  // 1 in the lanes that follow the law
  int count = 0;    // of them
  const Snow* any = nullptr;

  Followers(const Model<T>& model, const std::uint16_t* material, int count, int law) {
    for (int l = 0; l < count; ++l) {
      const Snow& snow = model.snows[material[l]];
      if (snow.law != law) continue;
      mark[l] = T(1), ++this->count;
      if (!any) any = &snow;
    }
  }
};

// The snow of the particles [p, p + count) if they are all of one, the usual case; else none.
template <class T>
const Snow* only_snow(const Model<T>& model, const State<T>& state, std::size_t p, std::size_t count) {
  const auto* material = state.material.data() + p;
  unsigned differ = 0;
  for (std::size_t l = 1; l < count; ++l) differ |= static_cast<unsigned>(material[l] ^ material[0]);
  return differ == 0 ? &model.snows[material[0]] : nullptr;
}

// The factors on stiffness and strength of a pack.
template <class R>
struct Factors {
  R stiffness, strength;

  template <class T>
  NEVE_INLINE static Factors of(const State<T>& state, std::size_t p, int count) {
    Factors f{load<R>(state.stiffness.column(0) + p, count), load<R>(state.strength.column(0) + p, count)};
    if (state.has_heat()) weaken(state, p, count, f.stiffness, f.strength);
    return f;
  }
};

// A law's parameters of a pack of several snows; lanes that follow another law get those of `one`.
template <class Law, class T>
auto parameters_of_each(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                        const Snow& one) {
  using R = Lanes<T>;
  const auto* material = state.material.data() + p;
  const auto given = Factors<R>::of(state, p, count);
  auto q = Law::parameters(one, given.stiffness, given.strength);
  using P = decltype(q);
  constexpr int entries = sizeof(P) / sizeof(R);
  R table[entries];
  std::memcpy(table, &q, sizeof(q));
  for (int l = 0; l < count; ++l) {
    const Snow& own = model.snows[material[l]];
    if (own.law != one.law) continue;
    const P mine = Law::parameters(own, given.stiffness, given.strength);
    R row[entries];
    std::memcpy(row, &mine, sizeof(mine));
    for (int e = 0; e < entries; ++e) table[e][l] = row[e][l];
  }
  std::memcpy(&q, table, sizeof(q));
  return q;
}

// Of a pack of several snows, see by_law().
template <class Out, class T, class F>
[[gnu::noinline]] Out by_each_law(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                                  const Mat3<Lanes<T>>& F_E, F&& f) {
  using R = Lanes<T>;
  const auto* material = state.material.data() + p;
  const auto here = first_lanes<R>(count);
  Out out{};
  for (int l = 0; l < count; ++l) {
    const int name = model.snows[material[l]].law;
    bool seen = false;
    for (int k = 0; k < l; ++k) seen = seen || model.snows[material[k]].law == name;
    if (seen) continue;
    const Followers<T> who(model, material, count, name);
    const auto mask = who.count == count ? here : who.mark > R{};
    out = select(mask,
                 with_law(name,
                          [&](auto law) -> Out {
                            return f(law, parameters_of_each<decltype(law)>(model, state, p, count, *who.any),
                                     quiet(F_E, mask));
                          }),
                 out);
  }
  return out;
}

// f(Law{}, parameters, F) for the pack's particles, each by its own law; F holds the identity in the lanes that are not
// the law's. `only`: their snow, if they are all of one.
template <class Out, class T, class F>
NEVE_INLINE Out by_law(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                       const Snow* only, const Mat3<Lanes<T>>& F_E, F&& f) {
  using R = Lanes<T>;
  if (!only) return by_each_law<Out>(model, state, p, count, F_E, f);
  return with_law(only->law, [&](auto law) -> Out {
    const auto given = Factors<R>::of(state, p, count);
    const auto q = decltype(law)::parameters(*only, given.stiffness, given.strength);
    if (count < width<R>) return f(law, q, quiet(F_E, first_lanes<R>(count)));
    return f(law, q, F_E);
  });
}

template <class Out, class T, class F>
Out by_law(const Model<T>& model, const State<T>& state, std::size_t p, int count, const Mat3<Lanes<T>>& F_E,
           F&& f) {
  return by_law<Out>(model, state, p, count, only_snow(model, state, p, static_cast<std::size_t>(count)), F_E,
                     f);
}

// Whether a particle may be pressed to ice: its snow flows, or it is water.
template <class T>
bool may_be_ice(const Model<T>& model, const State<T>& state, std::size_t p) {
  return model.snows[state.material[p]].plastic || (state.has_heat() && state.thermal.column(0)[p] >= T(1));
}

// The ice of a pack of particles, and 1 in the lanes that may come to it.
template <class T>
struct PackIce {
  Ice<Lanes<T>> ice;
  Lanes<T> mark{};

  PackIce(const Model<T>& model, const State<T>& state, std::size_t p, int count)
      : ice(Ice<Lanes<T>>::of(load<Lanes<T>>(state.m.column(0) + p, count),
                              load<Lanes<T>>(state.V0.column(0) + p, count))) {
    if (state.has_heat()) ice.J_ice = ice.J_ice * pressed_ratio(state, p, count);
    for (int l = 0; l < width<Lanes<T>>; ++l) {
      if (l < count && may_be_ice(model, state, p + static_cast<std::size_t>(l))) {
        mark[l] = T(1);
      } else {
        ice.J_ice[l] = T(1);
      }
    }
  }
};

// J over that at which snow is ice, for snow that flows; no bound for other snow.
template <class T>
NEVE_INLINE Lanes<T> ice_room(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                              const Lanes<T>& J) {
  using R = Lanes<T>;
  const R m = load<R>(state.m.column(0) + p, count), V0 = load<R>(state.V0.column(0) + p, count);
  const R none = splat<R>(std::numeric_limits<T>::max());
  R room = neve::ice_room(J, m, V0);
  if (state.has_heat()) room = room / pressed_ratio(state, p, count);
  room = select(first_lanes<R>(count), room, none);
  if (model.has_elastic_snow) {
    for (int l = 0; l < count; ++l) {
      if (!may_be_ice(model, state, p + static_cast<std::size_t>(l))) room[l] = std::numeric_limits<T>::max();
    }
  }
  return room;
}

// Add the stress of ice to particles that deform to J in dx / cell_speed.
template <class T>
[[gnu::noinline]] void add_ice(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                               const Lanes<T>& J, T cell_speed, Stress<Lanes<T>>& stress) {
  using R = Lanes<T>;
  const PackIce<T> pack(model, state, p, count);
  const R J_before =
      determinant(load_matrix<R>(state.F_E, p, count)) * load<R>(state.J_P.column(0) + p, count);
  neve::add_ice(pack.ice, J, J_before, cell_speed, pack.mark > splat<R>(0), stress);
}

}  // namespace detail

// The laws on the particles [p, p + count) of the state. `only`: their snow, if they are all of one. The return map is inlined into g2p, where a call costs a tenth
// of the stage; the others are called once a frame.

template <class T>
NEVE_INLINE Mapped<Lanes<T>> return_map(const Model<T>& model, const State<T>& state, std::size_t p,
                                        int count, const Snow* only, const Mat3<Lanes<T>>& F_trial,
                                        Lanes<T> J_P) {
  using Out = Mapped<Lanes<T>>;
  Out out = detail::by_law<Out>(
      model, state, p, count, only, F_trial,
      [&](auto law, const auto& q, const auto& F) -> Out { return decltype(law)::return_map(F, J_P, q); });
  if (state.has_heat()) detail::flow_as_water(state, p, count, F_trial, J_P, out);
  return out;
}

template <class T>
[[gnu::noinline]] Stress<Lanes<T>> stress(const Model<T>& model, const State<T>& state, std::size_t p,
                                          int count, const Mat3<Lanes<T>>& F_E, Lanes<T> J_P) {
  using Out = Stress<Lanes<T>>;
  Out out = detail::by_law<Out>(
      model, state, p, count, F_E,
      [&](auto law, const auto& q, const auto& F) -> Out { return decltype(law)::stress(F, J_P, q); });
  const Lanes<T> J = determinant(F_E) * J_P;
  if (state.has_heat()) {
    Mapped<Lanes<T>> mapped{F_E, J_P, out};
    detail::flow_as_water(state, p, count, F_E, J_P, mapped);
    out = mapped.stress;
    detail::add_water(model, state, p, count, J, out);
  }
  if (any(near_ice(detail::ice_room(model, state, p, count, J))))
    detail::add_ice(model, state, p, count, J, T(0), out);
  return out;
}

template <class T>
[[gnu::noinline]] Lanes<T> energy(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                                  const Mat3<Lanes<T>>& F_E, Lanes<T> J_P) {
  using Out = Lanes<T>;
  Out out = detail::by_law<Out>(
      model, state, p, count, F_E,
      [&](auto law, const auto& q, const auto& F) -> Out { return decltype(law)::energy(F, J_P, q); });
  const Out J = determinant(F_E) * J_P;
  if (state.has_heat()) {
    const auto is_snow = detail::liquid_share(state, p, count) < splat<Out>(1);
    out = select(is_snow, out, splat<Out>(0)) + detail::PackWater<T>(model, state, p, count, J).energy();
  }
  if (any(near_ice(detail::ice_room(model, state, p, count, J)))) {
    const detail::PackIce<T> pack(model, state, p, count);
    const Out psi = pack.ice.energy(max(pack.ice.beyond(J), splat<Out>(0)));
    out = select(pack.mark > Out{}, Out(out + psi), out);
  }
  return out;
}

}  // namespace neve
