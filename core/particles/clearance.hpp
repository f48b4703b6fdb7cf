// Which sleeping snow a moving solid has come to, asked only where one may have come near since it was last asked.
#pragma once

#include "particles/sleep.hpp"

namespace neve {

// Sleepers stay where they are. So a group that no point of a moving solid can reach before the solids have travelled some way
// need not be compared with them until they have.
template <class T>
class Clearance {
 public:
  // Ask all groups again.
  void clear() { crowd_.clear(), group_.clear(), seen_.clear(); }
  // Ask the groups of `crowd` again.
  void clear(std::size_t crowd) {
    const std::size_t n = moving_.size(), in_crowd = n * Groups<T>::in_crowd;
    if (crowd * n >= crowd_.size()) return;
    std::fill_n(crowd_.begin() + std::ptrdiff_t(crowd * n), n, 0.0);
    const std::size_t begin = crowd * in_crowd, end = std::min(group_.size(), begin + in_crowd);
    std::fill(group_.begin() + std::ptrdiff_t(begin), group_.begin() + std::ptrdiff_t(end), 0.0);
  }

  // The sleeping groups within `play` [m] of which a moving solid is now, in rising order.
  std::vector<std::uint32_t> met(const Model<T>& world, const ParticleState<T>& s, const Groups<T>& groups,
                                 double play) {
    follow(world, groups, play);
    std::vector<std::uint32_t> out;
    if (moving_.empty()) return out;
    std::vector<std::size_t> near;  // crowds
    for (std::size_t k = 0; k < groups.crowd_ball.size(); ++k) {
      const Around<T>& crowd = groups.crowd_ball[k];
      if (crowd.radius >= T(0) && may_meet(world, row(crowd_, k), crowd, play)) near.push_back(k);
    }
    std::vector<std::vector<std::uint32_t>> parts(near.size());
    each_index(near.size(), [&](std::size_t i) {
      const std::size_t begin = near[i] * groups.in_crowd;
      for (std::size_t g = begin; g < std::min(groups.asleep.size(), begin + groups.in_crowd); ++g) {
        if (groups.asleep[g] && meets(world, s, g, groups.ball[g], play))
          parts[i].push_back(std::uint32_t(g));
      }
    });
    for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
    return out;
  }

 private:
  static constexpr double endless = std::numeric_limits<double>::infinity();
  struct Pose {
    Vec3<T> centre;
    Mat3<T> rotation;
  };

  // Add what the solids have travelled since the last call. All is asked anew when others move, or `play` grows.
  void follow(const Model<T>& world, const Groups<T>& groups, double play) {
    std::vector<Pose> now;
    std::vector<std::size_t> moving;
    for (const Solid<T>& solid : world.solids) {
      if (detail::moves(solid)) moving.push_back(now.size());
      now.push_back({solid.centre, solid.rotation});
    }
    const std::size_t crowds = groups.crowd_ball.size() * moving.size(),
                      all = groups.asleep.size() * moving.size();
    if (now.size() == seen_.size() && moving == moving_ && play == play_ && crowd_.size() == crowds &&
        group_.size() == all) {
      for (std::size_t m = 0; m < moving.size(); ++m)
        travelled_[m] += travelled(world.solids[moving[m]], seen_[moving[m]]);
    } else {
      crowd_.assign(crowds, 0), group_.assign(all, 0), travelled_.assign(moving.size(), 0);
    }
    seen_ = std::move(now), moving_ = std::move(moving), play_ = play;
  }

  // The farthest that a point of a solid can have come [m]: an endless one that turns takes its points anywhere.
  static double travelled(const Solid<T>& solid, const Pose& before) {
    double shift2 = 0, turn2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = double(solid.centre[k]) - double(before.centre[k]);
      shift2 += d * d;
      for (int l = 0; l < 3; ++l) {
        const double r = double(solid.rotation(k, l)) - double(before.rotation(k, l));
        turn2 += r * r;
      }
    }
    return std::sqrt(shift2) + (turn2 > 0 ? std::sqrt(turn2) * reach_of(solid) : 0.0);
  }
  static double reach_of(const Solid<T>& solid) {
    if (!solid.mesh) return double(bounding_radius(solid.kind, solid.half));
    double far2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double far = std::max(std::abs(solid.mesh->low[k]), std::abs(solid.mesh->high[k]));
      far2 += far * far;
    }
    return std::sqrt(far2);
  }

  // By how much the distance that `surface` finds may be off the true one [m]: that of a mesh by half the diagonal of its cells,
  // but for samples far from its surface, of which it is only known that they are at least `band`.
  static double error_of(const Solid<T>& solid, double play) {
    if (!solid.mesh) return 0;
    return solid.mesh->band > 2 * play ? 0.8661 * solid.mesh->spacing : endless;
  }

  // How a moving solid lies to a ball: whether it may be within `play` of it, and how far it may travel before it can be [m].
  struct Nearness {
    bool may;
    double room;
  };
  static Nearness nearness(const Solid<T>& solid, const Around<T>& ball, double play) {
    const T reach = T(ball.radius + T(play));
    if (solid.terrain) return {is_near(solid, ball.middle, reach), 0};
    const double least = solid.mesh ? solid.mesh->least(local_of(solid, ball.middle))
                                    : double(surface(solid, ball.middle).phi);
    return {least <= double(reach), least - double(reach) - error_of(solid, play)};
  }

  // Whether a moving solid may be within `play` of `ball`. For each that is not, `until` says how far it may travel before that is
  // asked again.
  bool may_meet(const Model<T>& world, double* until, const Around<T>& ball, double play) const {
    bool may = false;
    for (std::size_t m = 0; m < moving_.size(); ++m) {
      if (travelled_[m] < until[m]) continue;
      const Nearness found = nearness(world.solids[moving_[m]], ball, play);
      may = may || found.may;
      if (!found.may) postpone(m, until[m], found.room, play);
    }
    return may;
  }

  // Whether a moving solid is within `play` of a particle of the sleeping group g, as may_meet().
  bool meets(const Model<T>& world, const ParticleState<T>& s, std::size_t g, const Around<T>& ball,
             double play) {
    using R = Lanes<T>;
    const std::size_t p = g * group_rows<T>;
    const int count = int(detail::end_of_group(s, g) - p);
    const R far = splat<R>(std::numeric_limits<T>::max());
    double* until = row(group_, g);
    for (std::size_t m = 0; m < moving_.size(); ++m) {
      if (travelled_[m] < until[m]) continue;
      const Solid<T>& solid = world.solids[moving_[m]];
      const Nearness found = nearness(solid, ball, play);
      double room = found.room;
      if (found.may) {
        const R phi = surface(solid, load_vector<R>(s.x, p, count)).phi;
        const R gap = select(first_lanes<R>(count), R(phi - load<R>(s.radius.column(0) + p, count)), far);
        if (any(gap <= T(play))) return true;
        room = std::max(room, room_of(solid, double(least_lane(gap)) - double(T(play)),
                                      double(largest_lane(select(first_lanes<R>(count), phi, -far))), play));
      }
      postpone(m, until[m], room, play);
    }
    return false;
  }

  // How far a solid may travel before what `surface` finds falls by `gap` at points where it is at most phi [m]. Within a mesh's bricks that
  // is a blend of distances at the corners of a cell, whose slope along each axis is at most 1.
  static double room_of(const Solid<T>& solid, double gap, double phi, double play) {
    if (!solid.mesh) return gap;
    const double error = error_of(solid, play), steep = gap / std::sqrt(3.0);
    return phi + steep + 2 * error <= solid.mesh->band ? steep : gap - 2 * error;
  }

  // Ask again when solid m of those that move has come `room` [m] nearer, less what rounding may hide.
  void postpone(std::size_t m, double& until, double room, double play) const {
    const double sure = 0.98 * room - 0.01 * play;
    if (sure > 0) until = travelled_[m] + sure;
  }
  // What `of` holds of the moving solids at one crowd or group.
  double* row(std::vector<double>& of, std::size_t i) const { return of.data() + i * moving_.size(); }

  std::vector<Pose> seen_;           // of all solids, at the last call
  std::vector<std::size_t> moving_;  // those that moved then
  std::vector<double>
      travelled_;  // by these: the farthest that a point of it can have come since all was asked [m]
  double play_ = 0;
  std::vector<double> crowd_, group_;  // by crowd or group and these: what that is when they are asked again
};

}  // namespace neve
