// Passes over the particles outside the step: stress from the state, initial volumes, energies, the lost particle.
#pragma once

#include "mpm/choices.hpp"
#include "mpm/g2p.hpp"

namespace neve {

// Recompute tau from F_E and J_P, and report the rates that limit the time step. Every advance() starts with it, so
// that a run depends on nothing but the state: not on what was left over by a step, a user's edit or a checkpoint.
template <class T>
Report refresh(const Model<T>& model, State<T>& state) {
  using R = Lanes<T>;
  constexpr int L = width<R>;
  return merge_each<Report>((state.count + L - 1) / L, [&](std::size_t i) {
    const std::size_t p = i * L;
    const int count = std::min<int>(L, static_cast<int>(state.count - p));
    const Mat3<R> F = load_matrix<R>(state.F_E, p, count);
    const R J_P = load<R>(state.J_P.column(0) + p, count);
    const Stress<R> now = stress(model, state, p, count, F, J_P);
    store_symmetric(state.tau, p, now.tau, count);
    const Vec3<R> x = load_vector<R>(state.x, p, count), v = load_vector<R>(state.v, p, count);
    const Mat3<R> C = load_matrix<R>(state.C, p, count);
    const R sum = detail::sum_of(x) + detail::sum_of(v) + detail::sum_of(F) + detail::sum_of(C) + J_P;
    detail::Extremes<R> extremes;
    extremes.add(state, p, count, v, now.modulus, C, sum);
    return extremes.report();
  });
}

// Stomakhin et al. 2013, section 4.1, step 2: rho_p = sum_i m_i w_ip / dx^3, V0_p = m_p / rho_p. Call after p2g.
template <class T, class S>
void volumes_from_grid(const Model<T>& model, State<T>& state, Grid<T>& grid) {
  using R = Lanes<T>;
  const T cell = static_cast<T>(model.dx * model.dx * model.dx);
  each_index(grid.homes.size(), [&](std::size_t h) {
    const Home& home = grid.homes[h];
    Tile<T> tile;
    tile.load_from(grid, home, &Grid<T>::node);
    Gather<T, S> from(tile);
    Stencils<T, S> st;
    const auto frame = TileFrame<T>::template of<S>(model.dx, home.at);
    for (std::uint32_t done = 0; done < home.count; done += width<R>) {
      const std::size_t p = home.begin + done;
      const int count = std::min<int>(width<R>, static_cast<int>(home.count - done));
      st.template fill<GradientWeights>(frame, load_vector<R>(state.x, p, count));
      for (int l = 0; l < count; ++l) {
        const T mass_per_cell = from.sum(st, l)[3];
        state.V0.column(0)[p + static_cast<std::size_t>(l)] =
            state.m.column(0)[p + static_cast<std::size_t>(l)] * cell / mass_per_cell;
      }
    }
  });
}

struct Totals {
  double mass = 0;
  double momentum[3] = {0, 0, 0};
  double kinetic = 0;  // of v_p alone
  double affine = 0;   // kinetic energy of C and of further modes
  double elastic = 0;
  double potential = 0;  // -m g . x
};

namespace detail {

// Kinetic energy per mass of all velocity modes but the first: 1/2 sum_r <s_r, s_r> |c_r|^2, <s, s> = sum_i w_ip s^2.
template <class S, class X, class T>
double affine_energy(const State<T>& state, std::size_t p, double dx) {
  if constexpr (!std::is_same_v<typename X::To, GradientWeights>) {
    double sum = 0;
    for (int k = 0; k < 9; ++k) {
      const double c = dx * state.C.column(k)[p];
      sum += c * c / S::inverse_inertia;
    }
    if constexpr (X::modes > 4) {
      double norm[3][3];  // of each axis and degree
      for (int a = 0; a < 3; ++a) {
        const double u = state.x.column(a)[p] / dx - S::shift, f = u - std::floor(u);
        double w[4], dw[4], phi[4];
        S::weights(f, w, dw);
        second_mode<S>(f, w, phi);
        norm[a][0] = 1, norm[a][1] = 1 / S::inverse_inertia, norm[a][2] = 0;
        for (int k = 0; k < S::nodes; ++k) norm[a][2] += w[k] * phi[k] * phi[k];
      }
      for (int n = 4; n < X::modes; ++n) {
        double own = 1;
        for (int a = 0; a < 3; ++a) own *= norm[a][X::order[static_cast<std::size_t>(n)].degree[a]];
        for (int k = 0; k < 3; ++k) {
          const double c = state.modes.column(3 * (n - 4) + k)[p];
          sum += own * c * c;
        }
      }
    }
    return 0.5 * sum;
  }
  return 0;
}

}  // namespace detail

// Sum in double, in chunks of fixed size merged in order: the same bits for any number of threads.
template <class T>
Totals totals(const Model<T>& model, const State<T>& state) {
  using R = Lanes<T>;
  constexpr std::size_t L = width<R>, chunk = 64 * L;
  std::vector<Totals> parts((state.count + chunk - 1) / chunk);
  const auto affine_energy = [&](std::size_t p) {
    return with_spline(model.spline, [&](auto spline) {
      return with_transfer(model, [&](auto transfer) {
        return detail::affine_energy<decltype(spline), decltype(transfer)>(state, p, model.dx);
      });
    });
  };
  each_index(parts.size(), [&](std::size_t c) {
    Totals& sum = parts[c];
    for (std::size_t p = c * chunk; p < std::min(state.count, (c + 1) * chunk); p += L) {
      const int count = static_cast<int>(std::min(L, state.count - p));
      const R psi = energy(model, state, p, count, load_matrix<R>(state.F_E, p, count),
                           load<R>(state.J_P.column(0) + p, count));
      for (int l = 0; l < count; ++l) {
        const std::size_t i = p + static_cast<std::size_t>(l);
        const double m = state.m.column(0)[i];
        double v2 = 0, gx = 0;
        for (int k = 0; k < 3; ++k) {
          const double v = state.v.column(k)[i];
          sum.momentum[k] += m * v;
          v2 += v * v;
          gx += static_cast<double>(model.gravity[k]) * state.x.column(k)[i];
        }
        sum.mass += m;
        sum.kinetic += 0.5 * m * v2;
        sum.affine += m * affine_energy(i);
        sum.elastic += static_cast<double>(psi[l]) * state.V0.column(0)[i];
        sum.potential -= m * gx;
      }
    }
  });
  Totals total;
  for (const Totals& part : parts) {
    total.mass += part.mass;
    for (int k = 0; k < 3; ++k) total.momentum[k] += part.momentum[k];
    total.kinetic += part.kinetic;
    total.affine += part.affine;
    total.elastic += part.elastic;
    total.potential += part.potential;
  }
  return total;
}

// The row of the first particle (by birth number) with a value that is not finite, or -1.
template <class T>
std::int64_t first_not_finite(const State<T>& state) {
  std::int64_t found = -1;
  for (std::size_t p = 0; p < state.count; ++p) {
    T sum = state.J_P.column(0)[p];
    for (int k = 0; k < 3; ++k) sum += state.x.column(k)[p] + state.v.column(k)[p];
    for (int k = 0; k < 9; ++k) sum += state.F_E.column(k)[p] + state.C.column(k)[p];
    for (int k = 0; k < 6; ++k) sum += state.tau.column(k)[p];
    for (int k = 0; k < state.modes.components(); ++k) sum += state.modes.column(k)[p];
    const bool earlier = found < 0 || state.id[p] < state.id[static_cast<std::size_t>(found)];
    if (sum - sum != T(0) && earlier) found = static_cast<std::int64_t>(p);
  }
  return found;
}

}  // namespace neve
