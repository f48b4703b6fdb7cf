// Solve A x = b on the nodes and bodies without a matrix: conjugate gradients, and conjugate residuals where A may be
// indefinite.
//
// Pieces of snow in the air, and with bodies, are preconditioned by the masses alone, and what friction adds to them. Then the
// search directions are changes of velocity by impulses that sum to zero on a piece of snow that nothing holds, or bodies
// alone, and its momentum is kept whatever the tolerance; and since the stiffness at a node is no more than a number times its
// mass, w^2 <= stiffness c^2 / dx^2, light nodes make no trouble. But their stiffness may be far less than that, with the square
// of their weights: where snow lies on what no snow moves, the diagonal of the stiffness is added to the masses.
#pragma once

#include "cpu/implicit/nodes/nodes.hpp"

namespace neve {

struct KrylovReport {
  int iterations = 0;
  bool converged =
      false;  // else: too many iterations, or a direction along which the energy falls without end
};

// Velocities of nodes, and q of bodies (bodies.hpp); or what is dual to them.
template <class T>
struct Unknowns {
  NodeField<T> nodes;
  std::vector<double> bodies;
  void resize(std::size_t blocks, std::size_t count) { nodes.resize(blocks), bodies.resize(count); }
};

template <class T>
class Krylov {
 public:
  using Vector = Unknowns<T>;
  void resize(std::size_t blocks, std::size_t bodies) {
    blocks_ = blocks;
    for (Vector* each : {&p_, &Ap_, &z_, &Ar_}) each->resize(blocks, bodies);
  }

  // u . w.
  static double product(const Vector& u, const Vector& w, std::size_t blocks, BlockSums& parts) {
    double sum = sum_products(u.nodes, w.nodes, blocks, parts);
    for (std::size_t k = 0; k < u.bodies.size(); ++k) sum += u.bodies[k] * w.bodies[k];
    return sum;
  }

  // x += A^-1 r, r the residual of x, until done(r); apply(u, out): out = A u; precondition(r, z): z = P^-1 r.
  template <class Apply, class Precondition, class Done>
  KrylovReport conjugate_gradients(Apply&& apply, Precondition&& precondition, Vector& x, Vector& r, int most,
                                   Done&& done) {
    KrylovReport report;
    double rz = 0;
    while (!(report.converged = done(r)) && report.iterations < most) {
      precondition(r, z_);
      const double before = rz;
      rz = product(r, z_);
      follow(z_, report.iterations ? rz / before : 0, p_, report.iterations == 0);
      apply(p_, Ap_);
      const double along = product(p_, Ap_);
      ++report.iterations;
      if (!(along > 0)) break;
      move(rz / along, x, p_, r, Ap_);
    }
    return report;
  }

  // The same for a symmetric A of any signs (Stomakhin et al. 2013 take this method).
  template <class Apply, class Precondition, class Done>
  KrylovReport conjugate_residuals(Apply&& apply, Precondition&& precondition, Vector& x, Vector& r, int most,
                                   Done&& done) {
    KrylovReport report;
    double gamma = 0;
    while (!(report.converged = done(r)) && report.iterations < most) {
      precondition(r, z_);
      apply(z_, Ar_);
      const double now = product(z_, Ar_), scale = report.iterations ? now / gamma : 0;
      gamma = now;
      follow(z_, scale, p_, report.iterations == 0);
      follow(Ar_, scale, Ap_, report.iterations == 0);
      precondition(Ap_, z_);
      const double size = product(Ap_, z_);
      ++report.iterations;
      if (!(size > 0) || !std::isfinite(gamma)) break;
      move(gamma / size, x, p_, r, Ap_);
    }
    return report;
  }

 private:
  double product(const Vector& u, const Vector& w) { return product(u, w, blocks_, parts_); }

  // p = z + scale p; of the first, what p was means nothing.
  void follow(const Vector& z, double scale, Vector& p, bool first) {
    each_block(blocks_, [&](std::size_t b) {
      T* to = p.nodes.block(b);
      const T* a = z.nodes.block(b);
      for (int i = 0; i < block_values; ++i) to[i] = a[i] + (first ? T(0) : T(scale) * to[i]);
    });
    for (std::size_t k = 0; k < z.bodies.size(); ++k)
      p.bodies[k] = z.bodies[k] + (first ? 0.0 : scale * p.bodies[k]);
  }
  void move(double step, Vector& x, const Vector& p, Vector& r, const Vector& Ap) {
    each_block(blocks_, [&](std::size_t b) {
      T *to = x.nodes.block(b), *left = r.nodes.block(b);
      const T *way = p.nodes.block(b), *image = Ap.nodes.block(b);
      for (int i = 0; i < block_values; ++i) to[i] += T(step) * way[i], left[i] -= T(step) * image[i];
    });
    for (std::size_t k = 0; k < x.bodies.size(); ++k)
      x.bodies[k] += step * p.bodies[k], r.bodies[k] -= step * Ap.bodies[k];
  }

  std::size_t blocks_ = 0;
  Vector p_, Ap_, Ar_, z_;
  BlockSums parts_;
};

}  // namespace neve
