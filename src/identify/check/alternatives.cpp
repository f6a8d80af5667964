#include "identify/check/alternatives.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "ranges.hpp"
#include "rivid/regressor/batch.hpp"

namespace rivid::detail {

namespace {

// Of lengths [m], angles [rad] and the sampling rate, for differences.
constexpr double small_step = 1e-5;
// Joints as far apart as the motors of wrists turn together.
constexpr Index coupled_reach = 2;
// Stribeck friction falls over this part of a joint's rms velocity.
constexpr double stribeck_part = 0.2;

bool is_revolute(const Robot& robot, Index j) {
  return robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute;
}

std::string joint_of(const Robot& robot, Index j) { return robot.joints[static_cast<std::size_t>(j)].name; }

template <typename Are>
std::vector<Index> columns_that(const BaseParameters& base, const Are& are) {
  return places_where(base.size(),
                      [&](Index i) { return are(base.parameters[static_cast<std::size_t>(i)].leading); });
}

// Torques of all joints along a motion, (samples × n).
Matrix torques_along(const RegressorBatch& batch, const Motion& motion, const Vector& chi) {
  RegressorBlock block(batch, std::max<Index>(motion.samples(), 1));
  batch.fill(motion, 0, motion.samples(), block);
  Matrix out(motion.samples(), static_cast<Index>(batch.joints()));
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    out.col(static_cast<Index>(j)) = block.W(j) * chi(batch.of_joint(j));
  }
  return out;
}

// Torques that the same parameters make in another robot or of another motion, less those of the
// experiment's.
class Effects {
 public:
  Effects(const Robot& robot, const BaseParameters& base, const ProbedRows& rows)
      : robot_(robot),
        columns_(base.columns()),
        rows_(rows),
        fitted_(rows.W * rows.chi),
        motions_(made_of(rows.logs, &PickedLog::motion)) {
    told_ = torques(robot, motions_);
  }

  // Per small_step, (rows).
  [[nodiscard]] Vector of(const Robot& other) const {
    return (torques(other, motions_) - told_) / small_step;
  }
  [[nodiscard]] Vector of(const std::vector<Motion>& others) const {
    return (torques(robot_, others) - told_) / small_step;
  }
  [[nodiscard]] const std::vector<Motion>& motions() const { return motions_; }
  // W χ, (rows).
  [[nodiscard]] const Vector& fitted() const { return fitted_; }

 private:
  [[nodiscard]] Vector torques(const Robot& robot, const std::vector<Motion>& motions) const {
    const RegressorBatch batch(robot, columns_);
    Vector out(rows_.Y.size());
    for (std::size_t l = 0; l < motions.size(); ++l) {
      const Matrix all = torques_along(batch, motions[l], rows_.chi);
      for (const ProbedRows::Piece& piece : rows_.pieces) {
        if (piece.log == l) {
          out.segment(piece.first, piece.size()) =
              rows_.weights[piece.joint] * all.col(piece.joint)(piece.instants);
        }
      }
    }
    return out;
  }

  const Robot& robot_;
  std::vector<StandardParameter> columns_;
  const ProbedRows& rows_;
  Vector fitted_;
  Vector told_;  // the same of the averaged motions
  std::vector<Motion> motions_;
};

Robot with_gravity(const Robot& robot, const Eigen::Vector3d& gravity) {
  Robot out = robot;
  out.chain.gravity = gravity;
  return out;
}

// Frame j moved and turned against the one before it, in its own axes.
Robot moved(const Robot& robot, Index j, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  Robot out = robot;
  Chain::Link& link = out.chain.links[static_cast<std::size_t>(j)];
  link.p += link.R * shift;
  if (turn.norm() > 0.0) {
    link.R = link.R * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  return out;
}

void add_gravity(const Robot& robot, const Effects& effects, std::vector<Alternative>& out) {
  if (robot.chain.gravity.norm() == 0.0) {
    return;
  }
  Matrix effect(effects.fitted().size(), 2);
  for (Index i = 0; i < 2; ++i) {
    effect.col(i) = effects.of(with_gravity(robot, tilted_gravity(robot, small_step * Vector::Unit(2, i))));
  }
  out.push_back({"gravity_tilt", robot.base.empty() ? "base" : robot.base, std::move(effect)});
}

void add_geometry(const Robot& robot, const Effects& effects, std::vector<Alternative>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    const Eigen::Vector3d z = small_step * Eigen::Vector3d::UnitZ();
    const bool revolute = is_revolute(robot, j);
    out.push_back({"zero_offset", joint_of(robot, j),
                   effects.of(revolute ? moved(robot, j, none, z) : moved(robot, j, z, none)), revolute});
    Matrix origin(effects.fitted().size(), 5);
    origin << effects.of(moved(robot, j, small_step * Eigen::Vector3d::UnitX(), none)),
        effects.of(moved(robot, j, small_step * Eigen::Vector3d::UnitY(), none)),
        effects.of(revolute ? moved(robot, j, z, none) : moved(robot, j, none, z)),
        effects.of(moved(robot, j, none, small_step * Eigen::Vector3d::UnitX())),
        effects.of(moved(robot, j, none, small_step * Eigen::Vector3d::UnitY()));
    out.push_back({"joint_origin", joint_of(robot, j), std::move(origin)});
  }
}

// Columns that are zero in the rows of all joints but one.
template <typename Of>
Matrix of_joint(const ProbedRows& rows, Index joint, Index columns, const Of& of) {
  Matrix out = Matrix::Zero(rows.Y.size(), columns);
  for (const ProbedRows::Piece& piece : rows.pieces) {
    if (piece.joint == joint) {
      out.middleRows(piece.first, piece.size()) = rows.weights[joint] * of(piece);
    }
  }
  return out;
}

void add_gains(const Robot& robot, const ProbedRows& rows, const Effects& effects,
               std::vector<Alternative>& out) {
  for (Index j = 0; robot.size() > 1 && j < robot.size(); ++j) {
    Matrix effect = Matrix::Zero(rows.Y.size(), 1);
    for (const ProbedRows::Piece& piece : rows.pieces) {
      if (piece.joint == j) {
        effect.col(0).segment(piece.first, piece.size()) =
            effects.fitted().segment(piece.first, piece.size());
      }
    }
    out.push_back({"torque_gain", joint_of(robot, j), std::move(effect)});
  }
}

// The parameters whose torques load gears and bearings: all but those of drives and friction.
Vector loading(const BaseParameters& base, const Vector& chi) {
  Vector out = chi;
  out(columns_that(base, [](const StandardParameter& p) {
    return role(p.kind) != Role::inertial;
  })).setZero();
  return out;
}

void add_friction(const Robot& robot, const BaseParameters& base, const ProbedRows& rows,
                  std::vector<Alternative>& out) {
  const Vector load = rows.W * loading(base, rows.chi);
  for (Index j = 0; j < robot.size(); ++j) {
    const auto speed = [&](const ProbedRows::Piece& piece) -> Vector {
      return rows.logs[piece.log].motion.qd.col(j)(piece.instants);
    };
    double squares = 0.0;
    double count = 0.0;
    for (const ProbedRows::Piece& piece : rows.pieces) {
      if (piece.joint == j) {
        squares += speed(piece).squaredNorm();
        count += static_cast<double>(piece.size());
      }
    }
    const double falls = stribeck_part * std::sqrt(squares / std::max(count, 1.0));
    out.push_back({"load_friction", joint_of(robot, j),
                   of_joint(rows, j, 1,
                            [&](const auto& piece) -> Matrix {
                              const auto own = load.segment(piece.first, piece.size());
                              return own.cwiseAbs().cwiseProduct(speed(piece).cwiseSign()) / rows.weights[j];
                            }),
                   is_revolute(robot, j)});
    out.push_back({"stribeck_friction", joint_of(robot, j),
                   of_joint(rows, j, 1,
                            [&](const auto& piece) -> Matrix {
                              const Vector v = speed(piece);
                              return v.cwiseSign().cwiseProduct(
                                  (-(v / falls).cwiseAbs2()).array().exp().matrix());
                            }),
                   is_revolute(robot, j)});
    out.push_back(
        {"direction_friction", joint_of(robot, j), of_joint(rows, j, 2, [&](const auto& piece) -> Matrix {
           const Vector v = speed(piece);
           Matrix E(v.size(), 2);
           E << v.cwiseMax(0.0), Vector((v.array() > 0.0).template cast<double>());
           return E;
         })});
  }
}

// Springs and counterbalances: torques in proportion to the position.
void add_springs(const Robot& robot, const ProbedRows& rows, std::vector<Alternative>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    out.push_back({"joint_spring", joint_of(robot, j),
                   of_joint(rows, j, 1,
                            [&](const auto& piece) -> Matrix {
                              return rows.logs[piece.log].motion.q.col(j)(piece.instants);
                            }),
                   is_revolute(robot, j)});
  }
}

void add_couplings(const Robot& robot, const ProbedRows& rows, std::vector<Alternative>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    for (Index k = j + 1; k < std::min(robot.size(), j + coupled_reach + 1); ++k) {
      const std::vector<std::size_t> path = robot.chain.path(static_cast<std::size_t>(k));
      if (std::ranges::find(path, static_cast<std::size_t>(j)) == path.end()) {
        continue;  // on another branch
      }
      const auto half = [&](Index own, Index other) {
        return of_joint(rows, own, 4, [&](const auto& piece) -> Matrix {
          const Motion& m = rows.logs[piece.log].motion;
          const Vector a = m.qdd.col(other)(piece.instants);
          const Vector v = m.qd.col(other)(piece.instants);
          const Vector mine = m.qd.col(own)(piece.instants);
          Matrix E(v.size(), 4);
          // The motor turns with the sum or with the difference, whose friction brakes the one and drives the
          // other.
          E << a, v, (mine + v).cwiseSign(), (mine - v).cwiseSign();
          return E;
        });
      };
      out.push_back(
          {"joint_coupling", joint_of(robot, j) + " and " + joint_of(robot, k), half(j, k) + half(k, j)});
    }
  }
}

// Derivatives by central differences over the instants of a log, with the first and the last one zero.
Matrix rate(const Matrix& x, double per_instant) {
  Matrix out = Matrix::Zero(x.rows(), x.cols());
  const Index inner = x.rows() - 2;
  if (inner > 0) {
    out.middleRows(1, inner) = (x.bottomRows(inner) - x.topRows(inner)) * (0.5 * per_instant);
  }
  return out;
}

Matrix second_rate(const Matrix& x, double per_instant) {
  Matrix out = Matrix::Zero(x.rows(), x.cols());
  const Index inner = x.rows() - 2;
  if (inner > 0) {
    out.middleRows(1, inner) =
        (x.bottomRows(inner) - 2.0 * x.middleRows(1, inner) + x.topRows(inner)) * (per_instant * per_instant);
  }
  return out;
}

// Torques that are recorded late, per second: their rate, without that of dry friction, which jumps.
void add_delay(const Robot& robot, const BaseParameters& base, const ProbedRows& rows,
               std::vector<Alternative>& out) {
  const RegressorBatch batch(robot, base.columns());
  Vector chi = rows.chi;
  chi(columns_that(base, [](const StandardParameter& p) { return role(p.kind) == Role::dry; })).setZero();
  Matrix effect = Matrix::Zero(rows.Y.size(), 1);
  for (std::size_t l = 0; l < rows.logs.size(); ++l) {
    const ProbedLog& log = *rows.logs[l].log;
    if (log.size() < 3) {
      continue;
    }
    const double per_instant = log.log->f_m / static_cast<double>(log.samples[1] - log.samples[0]);
    const Matrix late =
        -rate(torques_along(batch, log.motion, chi), per_instant)(rows.logs[l].instants, Eigen::all);
    for (const ProbedRows::Piece& piece : rows.pieces) {
      if (piece.log == l) {
        effect.col(0).segment(piece.first, piece.size()) =
            rows.weights[piece.joint] * late.col(piece.joint)(piece.instants);
      }
    }
  }
  out.push_back({"torque_delay", "all joints", std::move(effect)});
}

// Mean over the picked poses of what joint j feels of its link and all beyond it when it is accelerated,
// without its rotor where that is a parameter of its own.
double link_inertia(const Robot& robot, const BaseParameters& base, const Vector& loads, Index j,
                    std::vector<Motion> motions) {
  const RegressorBatch batch(with_gravity(robot, Eigen::Vector3d::Zero()), base.columns());
  double sum = 0.0;
  double instants = 0.0;
  for (Motion& motion : motions) {
    motion.qd.setZero();
    motion.qdd.setZero();
    motion.qdd.col(j).setOnes();
    const Vector own = torques_along(batch, motion, loads).col(j);
    sum += own.sum();
    instants += static_cast<double>(motion.samples());
  }
  return sum / std::max(instants, 1.0);
}

// The encoder of an elastic joint sits at the motor: the link is behind by the load over the stiffness.
void add_elasticity(const Robot& robot, const BaseParameters& base, const ProbedRows& rows,
                    const Effects& effects, std::vector<Alternative>& out) {
  const RegressorBatch batch(robot, base.columns());
  const Vector loads = loading(base, rows.chi);
  const std::vector<Matrix> load = made_of(  // of each log, (instants × n)
      rows.logs, [&](const PickedLog& log) { return torques_along(batch, log.log->motion, loads); });
  for (Index j = 0; j < robot.size(); ++j) {
    std::vector<Motion> motions = effects.motions();
    for (std::size_t l = 0; l < motions.size(); ++l) {
      const ProbedLog& log = *rows.logs[l].log;
      const std::vector<Index>& picked = rows.logs[l].instants;
      if (log.size() < 3) {
        continue;
      }
      const Matrix own = load[l].col(j);
      const double per_instant = log.log->f_m / static_cast<double>(log.samples[1] - log.samples[0]);
      motions[l].q.col(j) -= small_step * own(picked, 0);
      motions[l].qd.col(j) -= small_step * rate(own, per_instant)(picked, 0);
      motions[l].qdd.col(j) -= small_step * second_rate(own, per_instant)(picked, 0);
    }
    out.push_back({"joint_elasticity", joint_of(robot, j), effects.of(motions), is_revolute(robot, j), 0.0,
                   link_inertia(robot, base, loads, j, effects.motions())});
  }
}

// Positions of another scale, of each joint and of all.
void add_scales(const Robot& robot, const Effects& effects, std::vector<Alternative>& out) {
  for (Index j = 0; robot.size() > 1 && j <= robot.size(); ++j) {
    const bool all = j == robot.size();
    std::vector<Motion> motions = effects.motions();
    for (Motion& motion : motions) {
      for (Matrix* const x : {&motion.q, &motion.qd, &motion.qdd}) {
        x->middleCols(all ? 0 : j, all ? j : 1) *= 1.0 + small_step;
      }
    }
    out.push_back({"position_scale", all ? "all joints" : joint_of(robot, j), effects.of(motions)});
  }
}

std::vector<Motion> faster(std::vector<Motion> motions) {
  for (Motion& motion : motions) {
    motion.qd *= 1.0 + small_step;
    motion.qdd *= (1.0 + small_step) * (1.0 + small_step);
  }
  return motions;
}

// What a load of a link does to the torques: its mass, first moments, and inertia about the axis of its
// joint. Base parameters of the links before take up most of the mass.
Matrix load_effect(std::size_t link, const BaseParameters& base, const ProbedRows& rows) {
  std::vector<Vector> of_chi;
  for (std::size_t k = 0; k < base.standard.size(); ++k) {
    const StandardParameter& p = base.standard[k];
    const bool is_load = p.kind == ParameterKind::ZZ || p.kind == ParameterKind::MX ||
                         p.kind == ParameterKind::MY || p.kind == ParameterKind::MZ ||
                         p.kind == ParameterKind::M;
    if (p.joint == static_cast<Index>(link) && is_load) {
      of_chi.push_back(base.from_standard(Vector::Unit(std::ssize(base.standard), static_cast<Index>(k))));
    }
  }
  Matrix out(rows.W.rows(), std::ssize(of_chi));
  for (Index c = 0; c < out.cols(); ++c) {
    out.col(c) = rows.W.leftCols(base.size()) * of_chi[static_cast<std::size_t>(c)];
  }
  return out;
}

// Another load from some instant on, or one that comes and goes: each part of the time has its own.
void add_load_changes(const Robot& robot, std::size_t tip, const BaseParameters& base, const ProbedRows& rows,
                      std::vector<Alternative>& out) {
  // of a change, evenly over the time; a choice: each takes a test, fewer lie farther from the change
  constexpr Index instants = 5;
  // of the time, each with a load of its own; a choice: more follow faster changes by fewer rows each
  constexpr Index parts = 10;
  const Index blocks_of_part = std::max<Index>(rows.blocks / parts, 2);
  const Matrix whole = load_effect(tip, base, rows);
  const Index columns = whole.cols();
  for (Index k = 1; k <= instants; ++k) {
    const Index from = k * rows.blocks / (instants + 1);
    Matrix effect = whole;
    for (Index r = 0; r < effect.rows(); ++r) {
      if (rows.block_of[static_cast<std::size_t>(r)] < from) {
        effect.row(r).setZero();
      }
    }
    out.push_back({"load_changed", robot.link_name(tip), std::move(effect), true,
                   static_cast<double>(k) / (instants + 1)});
  }
  double seconds = 0.0;
  for (const PickedLog& picked : rows.logs) {
    const ProbedLog& log = *picked.log;
    seconds +=
        log.size() > 0 ? static_cast<double>(log.samples.back() - log.samples.front()) / log.log->f_m : 0.0;
  }
  constexpr Index rows_of_column = 5;  // at least; a choice: with fewer, so many columns fit any residual
  const Index all = columns * (rows.blocks / blocks_of_part);
  // Residuals are alike for parts of a second, whatever they come from.
  if (whole.rows() < rows_of_column * all || seconds < 0.5 * parts) {
    return;
  }
  Matrix effect = Matrix::Zero(whole.rows(), all);
  for (Index r = 0; r < effect.rows(); ++r) {
    const Index part = rows.block_of[static_cast<std::size_t>(r)] / blocks_of_part;
    if ((part + 1) * columns <= effect.cols()) {
      effect.row(r).segment(part * columns, columns) = whole.row(r);
    }
  }
  out.push_back({"load_changed", robot.link_name(tip), std::move(effect)});
  out.back().by_blocks = true;
}

}  // namespace

Eigen::Vector3d tilted_gravity(const Robot& robot, const Vector& angles) {
  const Eigen::Vector3d& g = robot.chain.gravity;
  const Eigen::Vector3d first = g.unitOrthogonal();
  const Eigen::Vector3d axis = angles[0] * first + angles[1] * g.normalized().cross(first);
  return axis.norm() > 0.0 ? Eigen::Vector3d(Eigen::AngleAxisd(axis.norm(), axis.normalized()) * g) : g;
}

std::vector<Alternative> alternatives(const Robot& robot, const BaseParameters& base,
                                      const ProbedRows& rows) {
  const Effects effects(robot, base, rows);
  std::vector<Alternative> out;
  add_gains(robot, rows, effects, out);
  add_gravity(robot, effects, out);
  out.push_back({"clock_rate", "all joints", effects.of(faster(effects.motions()))});
  add_scales(robot, effects, out);
  add_delay(robot, base, rows, out);
  add_geometry(robot, effects, out);
  for (const std::size_t tip : robot.chain.tips()) {
    add_load_changes(robot, tip, base, rows, out);
  }
  add_elasticity(robot, base, rows, effects, out);
  add_friction(robot, base, rows, out);
  add_springs(robot, rows, out);
  add_couplings(robot, rows, out);
  return out;
}

OwnLog own_log(const Robot& robot, const BaseParameters& base, const ProbedRows& rows, std::size_t log) {
  const auto of_log = [&](const std::vector<Index>& columns) {
    Matrix out = Matrix::Zero(rows.W.rows(), std::ssize(columns));
    for (const ProbedRows::Piece& piece : rows.pieces) {
      if (piece.log == log) {
        const auto some = Eigen::seqN(piece.first, piece.size());
        out(some, Eigen::all) = rows.W(some, columns);
      }
    }
    return out;
  };
  OwnLog out;
  const std::vector<std::size_t> tips = robot.chain.tips();
  const auto is_tip = [&](int joint) {
    return std::ranges::find(tips, static_cast<std::size_t>(joint)) != tips.end();
  };
  for (const bool load : {true, false}) {
    const std::vector<Index> bodies = columns_that(base, [&](const StandardParameter& p) {
      return role(p.kind) == Role::inertial && (!load || is_tip(p.joint));
    });
    Alternative& one = out.bodies.emplace_back();
    one.code = "logs_differ";
    one.subject = rows.logs[log].log->log->source;
    one.effect = of_log(bodies);
    one.load = load;
    one.by_blocks = true;
  }
  out.friction = of_log(columns_that(base, [](const StandardParameter& p) { return is_friction(p.kind); }));
  return out;
}

}  // namespace rivid::detail
