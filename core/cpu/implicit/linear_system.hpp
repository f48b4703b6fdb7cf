// The linear system of an implicit step, (M + H + friction) x = r on the nodes and bodies that are free to move: what is left
// over at a velocity, the product, the preconditioner, and whether a residual is small enough.
#pragma once

#include "cpu/implicit/stopping_test.hpp"
#include "cpu/implicit/tangents.hpp"

namespace neve {

template <class T>
class LinearSystem {
 public:
  using Vector = Unknowns<T>;

  NodeField<T> mass;
  BodyContacts<T> contacts;
  BodyUnknowns bodies;
  Tangents<T> tangents;
  std::vector<double> q;  // of the bodies now

  // Find the contacts of nodes that have their masses and velocities v, and the bodies among them, which begin as they moved
  // before. In a step of dt [s].
  void find(const Model<T>& model, const Grid<T>& grid, const NodeField<T>& v, double dt) {
    blocks_ = grid.blocks.size();
    inverse_.resize(blocks_);
    contacts.find(model, grid, mass, v, dt);
    body_count_ = model.bodies.count();
    std::vector<bool> touched(body_count_);
    for (const auto& met : contacts.met_bodies()) touched[met.first] = true;
    bodies.find(model.bodies, dt, touched);
    test_.find(grid, bodies, contacts);
    find_lying();
    diagonal_.resize(blocks_);
    image_.resize(blocks_, bodies.count());
    q = bodies.as_before();
    if (body_count_ > 0) contacts.move_bodies(bodies.velocities(q));
  }
  // Find the scales of residuals. `fall`, dt g; `stress`, dt f at the start.
  void scale(const T (&fall)[4], const NodeField<T>& stress) {
    add_drag_to_masses();
    test_.begin(mass, inverse_, fall, stress, blocks_, bodies, contacts, q);
  }

  std::size_t body_count() const { return body_count_; }

  // Give the nodes that are held the velocities of what holds them, bodies at q. Whether that changed any.
  bool fix(NodeField<T>& v) {
    if (body_count_ > 0) contacts.move_bodies(bodies.velocities(q));
    return contacts.fix(v);
  }

  // Nodes too light to have a velocity take no part.
  void drop_massless(NodeField<T>& a) const {
    each_block(blocks_, [&](std::size_t b) {
      const T* m = mass.block(b);
      T* out = a.block(b);
      for (int i = 0; i < block_values; ++i) out[i] = m[i] > T(0) ? out[i] : T(0);
    });
  }

  // r = -(left + friction) where the velocity is not given, and of bodies L^T P - q.
  void find_residual(const NodeField<T>& v, const NodeField<T>& left, Vector& r) {
    each_block(blocks_, [&](std::size_t b) { std::copy_n(left.block(b), block_values, r.nodes.block(b)); });
    add_drag_to_masses();
    contacts.add_friction(v, r.nodes);
    if (bodies.count() > 0) {
      r.bodies = bodies.transposed(contacts.given(r.nodes, v, body_count_));
      for (std::size_t k = 0; k < q.size(); ++k) r.bodies[k] = -(r.bodies[k] + q[k]);
    }
    contacts.project(r.nodes);
    each_block(blocks_, [&](std::size_t b) {
      T* to = r.nodes.block(b);
      for (int i = 0; i < block_values; ++i) to[i] = -to[i];
    });
  }

  // out = (M + H + friction) u where the velocity is not given. Nodes that bodies hold go with them meanwhile.
  template <class Step>
  void multiply(const Step& step, Vector& u, Vector& out) {
    if (bodies.count() > 0) contacts.carry(bodies.changes(u.bodies), u.nodes);
    each_block(blocks_, [&](std::size_t b) {
      const T *m = mass.block(b), *a = u.nodes.block(b);
      for (int i = 0; i < block_values; ++i) out.nodes.block(b)[i] = m[i] * a[i];
    });
    step.add_stiffness(tangents, u.nodes, out.nodes);
    drop_massless(out.nodes);
    contacts.add_friction_change(u.nodes, out.nodes);
    if (bodies.count() > 0) {
      out.bodies = bodies.transposed(contacts.change_given(out.nodes, u.nodes, body_count_));
      for (std::size_t k = 0; k < out.bodies.size(); ++k) out.bodies[k] += u.bodies[k];
      contacts.project(u.nodes);
    }
    contacts.project(out.nodes);
  }

  // From now on precondition with the diagonal of `step`, too, where snow lies on what no snow moves; else, if not `wanted`,
  // with the masses alone. The diagonal is that of the tangents now.
  template <class Step>
  void find_diagonal(const Step& step, bool wanted) {
    has_diagonal_ = wanted && !lies_.empty();
    if (!has_diagonal_) return;
    each_lying_block([&](std::size_t b) { std::fill_n(diagonal_.block(b), block_values, T(0)); });
    step.add_diagonal(tangents, diagonal_,
                      [&](const Home& home) { return lies(static_cast<std::size_t>(home.nodes[0])); });
    each_lying_block([&](std::size_t b) {
      const T* d = inverse_.block(b);
      T* h = diagonal_.block(b);
      for (int i = 0; i < block_values; ++i) h[i] = d[i] > T(0) ? h[i] : T(0);
    });
  }

  // z = (M + friction + what find_diagonal() has found)^-1 r: bodies first, on which nodes that they rub hang.
  void precondition(const Vector& r, Vector& z) const {
    each_block(blocks_, [&](std::size_t b) {
      const T *a = r.nodes.block(b), *d = inverse_.block(b), *h = diagonal_.block(b);
      T* out = z.nodes.block(b);
      if (has_diagonal_ && lies(b)) {
        for (int i = 0; i < block_values; ++i) out[i] = d[i] * a[i] / (T(1) + d[i] * h[i]);
      } else {
        for (int i = 0; i < block_values; ++i) out[i] = d[i] * a[i];
      }
    });
    if (!lies_.empty()) contacts.project(z.nodes);
    if (bodies.count() == 0) return;
    std::vector<double> all = bodies.transposed(contacts.dragged(r.nodes, inverse_, body_count_));
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += r.bodies[k];
    z.bodies = bodies.precondition(all);
    contacts.drag(bodies.changes(z.bodies), inverse_, z.nodes);
  }

  // From now on no residual need be smaller than what rounding leaves at the velocities v.
  template <class Step>
  void allow_rounding(const Step& step, const NodeField<T>& v, double tolerance) {
    each_block(blocks_, [&](std::size_t b) { std::fill_n(image_.nodes.block(b), block_values, T(0)); });
    step.add_rounding(tangents, image_.nodes);
    drop_massless(image_.nodes);
    if (bodies.count() > 0) image_.bodies = bodies.transposed(contacts.passed_on(image_.nodes, body_count_));
    contacts.project(image_.nodes);
    test_.allow(image_, v, mass, inverse_, blocks_, bodies, tolerance);
  }

  // The largest residual of a piece over its scale; what is left over at the start raises the scale.
  double worst(const Vector& r, bool at_start = false) {
    return test_.worst(r, inverse_, blocks_, bodies, q, at_start);
  }

  // x, and r - A x: the translation of each piece, bodies included, that the residual asks for, of one that nothing holds all
  // of its fall.
  template <class Step>
  void carry_along(const Step& step, Vector& x, Vector& r) {
    const std::vector<double> along = translations(r);
    each_block(blocks_, [&](std::size_t b) {
      const double* u = along.data() + 3 * test_.pieces().of(b);
      for (int i = 0; i < block_values; ++i) {
        const bool is = i % 4 != 3 && mass.block(b)[i] > T(0);
        x.nodes.block(b)[i] = is ? T(u[i % 4]) : T(0);
      }
    });
    each_body_unknown([&](const auto& group, std::size_t piece, std::size_t k) {
      x.bodies[group.first + k] = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        x.bodies[group.first + k] += along[3 * piece + axis] * group.t[axis][k];
    });
    contacts.project(x.nodes);
    multiply(step, x, image_);
    const std::vector<double> gain = by_piece(x, r), size = by_piece(x, image_);
    const auto share = [&](std::size_t c) { return size[c] > 0 ? gain[c] / size[c] : 0.0; };
    each_block(blocks_, [&](std::size_t b) {
      const T part = T(share(test_.pieces().of(b)));
      for (int i = 0; i < block_values; ++i) {
        x.nodes.block(b)[i] *= part;
        r.nodes.block(b)[i] -= part * image_.nodes.block(b)[i];
      }
    });
    each_body_unknown([&](const auto& group, std::size_t piece, std::size_t k) {
      x.bodies[group.first + k] *= share(piece);
      r.bodies[group.first + k] -= share(piece) * image_.bodies[group.first + k];
    });
  }

 private:
  // inverse_ = 1 / (m + drag), and the same of bodies.
  void add_drag_to_masses() {
    each_block(blocks_, [&](std::size_t b) {
      const T* m = mass.block(b);
      for (int i = 0; i < block_values; ++i) inverse_.block(b)[i] = m[i] > T(0) ? T(1) / m[i] : T(0);
    });
    contacts.add_to_inverse(mass, inverse_);
    if (bodies.count() > 0) bodies.load(contacts.loads(mass, inverse_, body_count_));
  }

  // Find the pieces that solids may hold, none of them a body.
  void find_lying() {
    lies_.assign(test_.pieces().count(), false);
    contacts.each_node([&](std::size_t b, bool) { lies_[test_.pieces().of(b)] = true; });
    contacts.each_node([&](std::size_t b, bool body) {
      if (body) lies_[test_.pieces().of(b)] = false;
    });
    if (std::find(lies_.begin(), lies_.end(), true) == lies_.end()) lies_.clear();
  }

  bool lies(std::size_t block) const { return lies_[test_.pieces().of(block)]; }
  template <class F>
  void each_lying_block(F&& f) {
    each_block(blocks_, [&](std::size_t b) {
      if (lies(b)) f(b);
    });
  }

  // Of each piece the residual over the mass.
  std::vector<double> translations(const Vector& r) const {
    const Pieces& pieces = test_.pieces();
    std::vector<double> along(3 * pieces.count()), masses(pieces.count());
    for (std::size_t b = 0; b < blocks_; ++b) {
      double sum[4] = {};
      for (int n = 0; n < 64; ++n) {
        for (int k = 0; k < 3; ++k) sum[k] += double(r.nodes.node(b, n)[k]);
        sum[3] += double(mass.node(b, n)[0]);
      }
      for (std::size_t k = 0; k < 3; ++k) along[3 * pieces.of(b) + k] += sum[k];
      masses[pieces.of(b)] += sum[3];
    }
    each_body_unknown([&](const auto& group, std::size_t piece, std::size_t k) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        along[3 * piece + axis] += group.t[axis][k] * r.bodies[group.first + k];
      masses[piece] += group.t[0][k] * group.t[0][k];
    });
    for (std::size_t i = 0; i < along.size(); ++i) along[i] /= masses[i / 3];
    return along;
  }
  // f(group, piece, k) for each unknown k of each group of bodies.
  template <class F>
  void each_body_unknown(F&& f) const {
    for (std::size_t g = 0; g < bodies.groups().size(); ++g) {
      for (std::size_t k = 0; k < bodies.groups()[g].rank; ++k)
        f(bodies.groups()[g], test_.piece_of_group(g), k);
    }
  }
  std::vector<double> by_piece(const Vector& u, const Vector& w) const {
    BlockSums parts;
    sum_products(u.nodes, w.nodes, blocks_, parts);
    std::vector<double> sums = test_.pieces().sums(parts);
    each_body_unknown([&](const auto& group, std::size_t piece, std::size_t k) {
      sums[piece] += u.bodies[group.first + k] * w.bodies[group.first + k];
    });
    return sums;
  }

  std::size_t blocks_ = 0, body_count_ = 0;
  NodeField<T> inverse_, diagonal_;
  std::vector<bool> lies_;     // of pieces; empty if none does
  bool has_diagonal_ = false;  // diagonal_ is that of the blocks of pieces that lie
  StoppingTest<T> test_;
  Vector image_;
};

}  // namespace neve
