// Step 6 of Stomakhin et al. 2013, section 4.1: velocities at the end of a step from implicit equations, in two ways.
//
//   semi-implicit   (M + beta dt^2 H) v = M (v_n + dt g) + dt f_n, H the stiffness at the start of the step: one linear system
//   implicit        M (v - v_n - dt g) = dt f(v), backward Euler: Newton's method on the incremental potential
//                   1/2 |v - v_n - dt g|_M^2 + sum_p V0 Psi(F_p(v)), whose forces are those of snow that has flowed
//
// Which surfaces hold snow and how much they rub follows from each solution (contacts.hpp), so a system is solved in rounds.
// Bodies that snow meets are part of the equations (bodies.hpp). stopping_test.hpp says when a solution is good enough.
#pragma once

#include "cpu/block_update.hpp"
#include "cpu/grid_update.hpp"
#include "cpu/implicit/energy_step.hpp"
#include "cpu/implicit/krylov.hpp"
#include "cpu/implicit/linear_system.hpp"

namespace neve {

struct ImplicitOptions {
  bool newton = false;  // backward Euler; else one linear system
  double beta = 1;      // of the linear system
  bool project =
      true;  // negative eigenvalues of the tangents become zero, by conjugate gradients; else residuals
  double tolerance = 1e-3;     // of the impulses of gravity and stress
  int most_iterations = 1000;  // of a linear system
  bool midpoint = false;  // the midpoint rule, see midpoint.hpp; else velocities at the end move the snow
  bool diagonal = true;   // precondition with the diagonal of what is projected, see krylov.hpp
};

// What became of a step.
struct ImplicitReport {
  int iterations = 0;   // of linear systems
  int rounds = 0;       // linear systems
  double residual = 0;  // of the solution, over the impulses of gravity and stress
  bool converged = false;
  bool contacts_settled =
      true;  // else they still changed after the most rounds, and stayed as they were then
};

template <class T>
class ImplicitSolver {
 public:
  ImplicitOptions options;
  ImplicitReport report;
  LearnedEnergies<T> learned;  // of laws that are to be taken from networks; for Newton's method

  LateChange<T> late;  // by the midpoint rule: what the particles get after g2p

  // From (m v, m) of p2g without force to (v, m) at the end of a step of dt [s], or in its middle by the midpoint rule; bodies
  // get the velocities that they will have then.
  GridReport solve(Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
    report = {};
    const double solved = options.midpoint ? 0.5 * dt : dt;
    with_implicit_step(model, state, grid, solved, energies(),
                       [&](const auto& step) { advance(step, model, grid, solved); });
    write(model, grid, dt);
    return merge_each<GridReport>(grid.moving,
                                  [&](std::size_t h) { return detail::grid_report_of(grid, grid.homes[h]); });
  }

 private:
  static constexpr int most_rounds = 40, most_halvings = 6;
  static constexpr int most_inner_rounds = 3;    // of a learned energy between expansions
  static constexpr int most_contact_rounds = 8;  // after which contacts stay as they are
  static constexpr double least_volume = 0.1;    // det f that a Newton step may come to
  using Vector = Unknowns<T>;

  LearnedEnergies<T>* energies() { return options.newton && learned.are_used() ? &learned : nullptr; }

  template <class Step>
  void advance(const Step& step, const Model<T>& model, Grid<T>& grid, double dt) {
    begin(step, model, grid, dt);
    report.converged = solve_rounds(step);
    if (options.midpoint) go_on(step);
  }

  // Masses, velocities and forces at the start, contacts, bodies, and the scale of the impulses.
  template <class Step>
  void begin(const Step& step, const Model<T>& model, Grid<T>& grid, double dt) {
    blocks_ = grid.blocks.size();
    for (NodeField<T>* each : {&system_.mass, &v_, &v_n_, &given_, &left_, &force_}) each->resize(blocks_);
    const T fall[4] = {model.gravity.x * T(dt), model.gravity.y * T(dt), model.gravity.z * T(dt), T(0)};
    each_block(blocks_, [&](std::size_t b) {
      const T* node = grid.node(static_cast<std::int32_t>(b));
      for (int i = 0; i < block_values; ++i) {
        const T m = node[i | 3];
        const bool is = i % 4 != 3 && has_velocity(m);
        system_.mass.block(b)[i] = is ? m : T(0);
        v_n_.block(b)[i] = v_.block(b)[i] = is ? node[i] / m : T(0);
        force_.block(b)[i] = T(0);
      }
    });
    step.add_force(force_);  // dt f_n
    each_block(blocks_, [&](std::size_t b) {
      for (int i = 0; i < block_values; ++i) {
        const T m = system_.mass.block(b)[i];
        if (!(m > T(0))) force_.block(b)[i] = T(0);
        given_.block(b)[i] =
            m * (v_n_.block(b)[i] + fall[i % 4]) + (options.newton ? T(0) : force_.block(b)[i]);
        left_.block(b)[i] = v_n_.block(b)[i] + fall[i % 4] + (m > T(0) ? force_.block(b)[i] / m : T(0));
      }
    });
    system_.find(model, grid, v_n_, dt);
    for (Vector* each : {&r_, &delta_}) each->resize(blocks_, system_.bodies.count());
    krylov_.resize(blocks_, system_.bodies.count());
    system_.contacts.begin(v_n_, left_, system_.mass);
    system_.scale(fall, force_);
    system_.fix(v_);
    if (options.newton) return;
    each_block(blocks_, [&](std::size_t b) { std::fill_n(left_.block(b), block_values, T(0)); });
    step.linearise(left_, options.beta, options.project, 1, system_.tangents);
  }

  // Solve until the equations hold and no contact changes.
  template <class Step>
  bool solve_rounds(const Step& step) {
    if (options.newton && !is_sound(step)) return false;
    expand(step);
    evaluate(step);
    for (int k = 0; k <= most_rounds; ++k) {
      const bool same = k == 0 || k >= most_contact_rounds || system_.contacts.follow(v_, left_);
      if (k == most_contact_rounds - 1) report.contacts_settled = same;
      if (system_.fix(v_)) evaluate(step);
      system_.find_residual(v_, left_, r_);
      report.residual = system_.worst(r_, report.rounds == 0);
      if (k == 0) expanded_residual_ = report.residual;
      if (needs_expansion()) {
        expand(step);
        evaluate(step);
        system_.find_residual(v_, left_, r_);
        report.residual = expanded_residual_ = system_.worst(r_);
      }
      if (report.residual <= options.tolerance) {
        if (same) return true;
        continue;  // solved with the contacts that there are now, too
      }
      if (k == most_rounds || !std::isfinite(report.residual)) return false;
      if (!solve_linear(step) || !move(step)) return false;
    }
    return false;
  }

  // Learned energies are minimised until a tenth is left over, or for a few rounds, and then expanded anew: their forces are
  // those of the law where they are expanded, so that what is left over there tells whether the step is solved.
  bool needs_expansion() {
    if (!energies() || rounds_expanded_ == report.rounds) return false;
    return report.residual <= std::max(options.tolerance, 0.1 * expanded_residual_) ||
           report.rounds - rounds_expanded_ >= most_inner_rounds || report.rounds == most_rounds;
  }
  template <class Step>
  void expand(const Step& step) {
    if (!energies()) return;
    step.expand(v_);
    rounds_expanded_ = report.rounds;
  }

  // left_: the impulses that the equations leave over at v_, but for friction.
  template <class Step>
  void evaluate(const Step& step) {
    each_block(blocks_, [&](std::size_t b) {
      const T *m = system_.mass.block(b), *u = v_.block(b), *g = given_.block(b);
      T* out = left_.block(b);
      if (options.newton) {
        std::fill_n(out, block_values, T(0));
      } else {
        for (int i = 0; i < block_values; ++i) out[i] = m[i] * u[i] - g[i];
      }
    });
    if (!options.newton) {
      step.add_stiffness(system_.tangents, v_, left_);
    } else {
      step.add_force(v_, left_);
      each_block(blocks_, [&](std::size_t b) {
        const T *m = system_.mass.block(b), *u = v_.block(b), *g = given_.block(b);
        T* out = left_.block(b);
        for (int i = 0; i < block_values; ++i) out[i] = m[i] * u[i] - g[i] - out[i];
      });
    }
    system_.drop_massless(left_);
  }
  // delta_: the solution of the linear system for r_.
  template <class Step>
  bool solve_linear(const Step& step) {
    if (options.newton) step.linearise(v_, 1, options.project, elastic_share(), system_.tangents);
    if (report.rounds == 0) system_.allow_rounding(step, v_, options.tolerance);
    const bool new_tangents = options.newton || report.rounds == 0;
    if (new_tangents) system_.find_diagonal(step, options.project && options.diagonal);
    system_.carry_along(step, delta_, r_);
    const auto apply = [&](Vector& u, Vector& out) { system_.multiply(step, u, out); };
    const double goal = std::max(0.5 * options.tolerance, options.newton ? 0.1 * report.residual : 0.0);
    const auto done = [&](const Vector& r) { return system_.worst(r) <= goal; };
    const auto precondition = [&](const Vector& r, Vector& z) { system_.precondition(r, z); };
    const KrylovReport found =
        options.project
            ? krylov_.conjugate_gradients(apply, precondition, delta_, r_, options.most_iterations, done)
            : krylov_.conjugate_residuals(apply, precondition, delta_, r_, options.most_iterations, done);
    report.iterations += found.iterations;
    ++report.rounds;
    return found.converged;
  }

  // The share of elastic derivatives in those of snow that flows. Particles may turn from flowing to not and back from round
  // to round; a stiffer system takes shorter steps, under which they settle.
  double elastic_share() const { return report.rounds < 6 ? 0.0 : report.rounds < 16 ? 0.2 : 0.5; }

  // v_ += delta_, of which Newton's method takes as much as the incremental potential falls along it: by its slope, which is
  // -(r . delta), and which float32 can tell where it cannot tell the energies.
  template <class Step>
  bool move(const Step& step) {
    if (!options.newton) {
      add_delta(1);
      evaluate(step);
      return true;
    }
    const double slope = slope_along();
    double taken = 0;
    for (int h = 0; h <= most_halvings; ++h) {
      const double share = std::pow(0.5, h);
      add_delta(share - taken);
      taken = share;
      if (!is_sound(step)) continue;
      evaluate(step);
      const double now = slope_along();
      if (std::isfinite(now) && now <= 0.5 * std::abs(slope)) return true;
    }
    return false;
  }
  void add_delta(double share) {
    each_block(blocks_, [&](std::size_t b) {
      for (int i = 0; i < block_values; ++i) v_.block(b)[i] += T(share) * delta_.nodes.block(b)[i];
    });
    for (std::size_t k = 0; k < system_.q.size(); ++k) system_.q[k] += share * delta_.bodies[k];
    if (!system_.q.empty()) system_.fix(v_);
  }
  // The derivative of the potential along delta_.
  double slope_along() {
    system_.find_residual(v_, left_, r_);
    BlockSums parts;
    return -Krylov<T>::product(r_, delta_, blocks_, parts);
  }
  template <class Step>
  bool is_sound(const Step& step) {
    const StretchReport found = step.look(v_);
    return found.finite && found.least_volume >= least_volume;
  }

  // From the middle of a step to its end: what particles will get then, and the impulses of the whole step, 2 left_ but for
  // the d of nodes that are held, which stays away.
  template <class Step>
  void go_on(const Step& step) {
    each_block(blocks_, [&](std::size_t b) {
      const T *m = system_.mass.block(b), *w = v_.block(b), *v = v_n_.block(b);
      for (int i = 0; i < block_values; ++i) {
        force_.block(b)[i] = w[i] - v[i];
        left_.block(b)[i] = T(2) * left_.block(b)[i] - m[i] * force_.block(b)[i];
      }
    });
    system_.contacts.project(force_);
    each_block(blocks_, [&](std::size_t b) {
      for (int i = 0; i < block_values; ++i)
        left_.block(b)[i] += system_.mass.block(b)[i] * force_.block(b)[i];
    });
    step.gather_late(force_, late);
  }

  // Hand the velocities to the grid, and what the solids gave to their books.
  void write(Model<T>& model, Grid<T>& grid, double dt) {
    const detail::BlockUpdate<T> update(model, dt, grid.has_change);
    each_block(blocks_, [&](std::size_t b) {
      const auto block = static_cast<std::int32_t>(b);
      T* node = grid.node(block);
      for (int i = 0; i < block_values; ++i) {
        if (i % 4 == 3) {
          if (!has_velocity(node[i])) node[i] = T(0);
          continue;
        }
        node[i] = v_.block(b)[i];
        if (grid.has_change) grid.node_change(block)[i] = v_.block(b)[i] - v_n_.block(b)[i];
      }
      if (grid.has_lift) std::memset(grid.node_lift(block), 0, block_values * sizeof(T));
      update.bound_velocities(grid, block);
    });
    const std::vector<Twist> got =
        system_.contacts.exchange(left_, v_, system_.body_count(), T(options.midpoint ? 2 : 1), grid);
    if (got.empty()) return;
    settle_with(model.bodies, got, grid);
    set_velocities(model.bodies, system_.bodies.velocities(system_.q), model.solids);
  }

  // Bodies are to get the impulses that give them the velocities which the snow has met: to what they got, `got`, add what
  // the residual of their equations is.
  void settle_with(const CoupledBodies& bodies, const std::vector<Twist>& got, Grid<T>& grid) {
    std::vector<double> rest = system_.bodies.transposed(got);
    for (std::size_t k = 0; k < rest.size(); ++k) rest[k] = system_.q[k] - rest[k];
    const std::vector<Twist> more = system_.bodies.impulses_of(rest),
                             U = system_.bodies.velocities(system_.q);
    for (std::size_t i = 0; i < more.size() && !grid.node_exchange.empty(); ++i) {
      Exchange& sum = grid.node_exchange.front().of(bodies.solids[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        sum.impulse[k] += more[i][k], sum.moment[k] += more[i][3 + k];
        sum.work -= more[i][k] * U[i][k] + more[i][3 + k] * U[i][3 + k];
      }
    }
  }

  std::size_t blocks_ = 0;
  NodeField<T> v_, v_n_, given_, left_, force_;
  Vector r_, delta_;
  LinearSystem<T> system_;
  Krylov<T> krylov_;
  int rounds_expanded_ = 0;
  double expanded_residual_ = 0;
};

}  // namespace neve
