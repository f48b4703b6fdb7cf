// What heat makes of particles of the material point method: melting, freezing, sintering (docs/heat.md).
#pragma once

#include "cpu/heat/nodes.hpp"
#include "cpu/material.hpp"
#include "heat/sintering.hpp"

namespace neve {

// What a pass over heat has found in them besides.
struct PhaseReport {
  bool changed = false;  // some particle's share of water: stresses are to be found anew
  bool woken = false;    // a particle that slept

  void merge(const PhaseReport& o) { changed = changed || o.changed, woken = woken || o.woken; }
};

namespace detail {

template <class T>
class PhaseChange {
  using R = Lanes<T>;

 public:
  PhaseChange(const Model<T>& model, State<T>& state) : model_(model), state_(state) {
    for (const Snow& snow : model.snows) {
      with_law(snow.law, [&](auto law) {
        using Law = decltype(law);
        compacts_.push_back(snow.plastic && Law::compacts);
        most_strength_.push_back(
            snow.plastic ? Law::most_strength(snow.template constants<typename Law::Constants>()) : 0.0);
      });
    }
  }

  // Let the particles follow their heat.
  PhaseReport change() {
    return merge_each<PhaseReport>((state_.count + wide - 1) / wide, [&](std::size_t i) {
      return change_pack(i * wide, int(std::min<std::size_t>(wide, state_.count - i * wide)));
    });
  }

  // Let snow that is at rest sinter for dt [s] of heat's own time. `rate`: of strain, of each particle [1/s].
  void sinter(const std::vector<double>& rate, double dt) {
    each_index(state_.count, [&](std::size_t p) {
      if (rate[p] <= sintering::at_rest) sinter_one(p, dt);
    });
  }

 private:
  static constexpr std::size_t wide = std::size_t(width<R>);

  static bool changes(double now, double f) {
    return now != f && (std::abs(now - f) >= heat::phase_step || now <= 0 || now >= 1);
  }

  PhaseReport change_pack(std::size_t p, int count) {
    PhaseReport out;
    R f{}, next{}, freezes{};
    for (int l = 0; l < count; ++l) {
      const std::size_t q = p + std::size_t(l);
      const double had = state_.thermal.column(0)[q];
      const double now = heat::liquid(state_.enthalpy.column(0)[q], state_.m.column(0)[q]);
      f[l] = next[l] = T(had);
      if (!changes(now, had)) continue;
      out.changed = true;
      next[l] = T(now);
      freezes[l] = T(now < had);
      if (state_.rest.components() > 0) {
        T& rest = state_.rest.column(0)[q];
        out.woken = out.woken || rest == std::numeric_limits<T>::infinity();
        rest = T(0);
      }
      if (had >= 1 && now < 1) rest_here(q);
    }
    if (out.changed) apply(p, count, f, next, freezes > R{});
    return out;
  }

  // Take the volume of a particle without stress as that at rest, if its snow cannot be compacted to it.
  void rest_here(std::size_t q) {
    if (compacts_[state_.material[q]]) return;
    T &V0 = state_.V0.column(0)[q], &J = state_.J_P.column(0)[q];
    V0 *= J, J = T(1);
  }

  // Go from the share f of water to `next`. What freezes comes to the skeleton without a stress of its own, so that the
  // strain of the whole is the smaller. None gains energy: what freezes would rather have no stress at all, and what melts
  // forget that it is denser than ice.
  template <class M>
  void apply(std::size_t p, int count, const R& f, const R& next, const M& freezes) {
    const R one = splat<R>(1), least = splat<R>(T(least_skeleton));
    const Mat3<R> F = load_matrix<R>(state_.F_E, p, count);
    const R J_P = load<R>(state_.J_P.column(0) + p, count), J = determinant(F) * J_P;
    const R before = energy(model_, state_, p, count, F, J_P);
    const R had = max(R(one - f), least), has = max(R(one - next), least);
    const R rest = select(freezes, R(one - had / has), R{});
    Mat3<R> kept =
        any(freezes) ? with_stretches(F, [&](const auto& at) { return at.without(at.strain * rest); }) : F;
    const auto melts = (next >= one) & (f < one), was_water = f >= one;
    kept = select(melts | was_water, identity<R>(), kept);
    const R most = max(splat<R>(1), dense_volume(state_, p, count));  // at birth: what is torn apart closes
    const R J_kept = select(melts, min(J, most), R(J / determinant(kept)));
    store_matrix(state_.F_E, p, kept, count);
    store(state_.J_P.column(0) + p, select(freezes | melts, J_kept, J_P), count);
    store(state_.thermal.column(0) + p, next, count);
    for (int l = 0; l < count; ++l) {
      T &grown = state_.thermal.column(1)[p + std::size_t(l)],
        &most = state_.thermal.column(2)[p + std::size_t(l)];
      if (melts[l]) grown = T(1);
      most = std::max(most, next[l]);
    }
    const R after = energy(model_, state_, p, count, kept, load<R>(state_.J_P.column(0) + p, count));
    const R dense = dense_volume(state_, p, count);
    for (int l = 0; l < count; ++l) {
      if (!(after[l] > before[l])) continue;
      if (freezes[l]) release(p + std::size_t(l), J[l]);
      if (next[l] > f[l]) state_.J_P.column(0)[p + std::size_t(l)] *= std::max(dense[l] / J[l], T(1));
    }
  }

  // Let a particle of volume ratio J be without stress where it is.
  void release(std::size_t q, T J) {
    for (int k = 0; k < 9; ++k) state_.F_E.column(k)[q] = T(k % 4 == 0);
    state_.J_P.column(0)[q] = J;
    rest_here(q);
  }

  void sinter_one(std::size_t p, double dt) {
    const std::uint16_t row = state_.material[p];
    const double f = state_.thermal.column(0)[p], strength = state_.strength.column(0)[p];
    // What has come apart in a law whose J_P remembers it would store energy by growing stronger.
    if (f >= 1 || !(strength > 0) || (!compacts_[row] && double(state_.J_P.column(0)[p]) > 1)) return;
    const double m = state_.m.column(0)[p], J = volume_ratio(p);
    const double rho = m / (double(state_.V0.column(0)[p]) * J);
    const double most = std::min(sintering::strength_of_ice(rho), most_strength_[row] / strength);
    T& grown = state_.thermal.column(1)[p];
    const double celsius = heat::temperature(state_.enthalpy.column(0)[p], m);
    grown = std::max(grown, T(sintering::grown(std::max(double(grown), 1.0), 1.0, most, celsius, dt)));
  }
  double volume_ratio(std::size_t p) const {
    Mat3<double> F;
    for (int k = 0; k < 9; ++k) F(k % 3, k / 3) = state_.F_E.column(k)[p];
    return std::max(determinant(F) * double(state_.J_P.column(0)[p]), 1e-3);
  }

  const Model<T>& model_;
  State<T>& state_;
  std::vector<char> compacts_;         // of each row of the material table
  std::vector<double> most_strength_;  // [1]
};

// |sym grad v| of each particle on the grid [1/s].
template <class T>
std::vector<double> strain_rates(const State<T>& state, HeatNodes<T>& nodes) {
  std::array<std::vector<double>, 4> node;  // m v, m; then v
  for (auto& of : node) of.resize(nodes.size());
  nodes.template scatter<4>({node[0].data(), node[1].data(), node[2].data(), node[3].data()},
                            [&](std::size_t p) {
                              const double m = double(state.m.column(0)[p]);
                              std::array<double, 4> out{0, 0, 0, m};
                              for (int k = 0; k < 3; ++k)
                                out[std::size_t(k)] = m * double(state.v.column(k)[p]);
                              return out;
                            });
  each_chunk(nodes.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      for (std::size_t k = 0; k < 3; ++k) node[k][n] = node[3][n] > 0 ? node[k][n] / node[3][n] : 0.0;
    }
  });
  std::vector<double> out(state.count);
  nodes.template gather_slopes<3>({node[0].data(), node[1].data(), node[2].data()},
                                  [&](std::size_t p, const auto& dv) {
                                    double sum = 0;
                                    for (std::size_t a = 0; a < 3; ++a) {
                                      for (std::size_t b = 0; b < 3; ++b) {
                                        const double D = 0.5 * (dv[a][b] + dv[b][a]);
                                        sum += D * D;
                                      }
                                    }
                                    out[p] = std::sqrt(sum);
                                  });
  return out;
}

}  // namespace detail

}  // namespace neve
