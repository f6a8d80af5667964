#include "experiment/floating_base.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "model/link_poses.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double degrees = 180.0 / std::numbers::pi;  // for each radian
constexpr double steepest = 85.0;                     // of the pitch; at 90° yaw and roll are one rotation
constexpr double quaternion_tolerance = 0.01;  // of a norm of 1; a choice: printed with two digits and more

Log columns_of(const LogSource& source, std::vector<Column> columns, const ColumnsRead& read) {
  const LogOptions options = {.position = std::move(columns),
                              .time = source.columns.time,
                              .rate_hz = source.columns.rate_hz,
                              .default_names = false,
                              .table = source.columns.table};
  return read(options);
}

// Columns of yaw, pitch and roll; yaw and roll without jumps.
Matrix angles(const Log& pose, Index first) {
  const Index m = pose.samples();
  Matrix out(m, 3);
  for (Index k = 0; k < m; ++k) {
    if (pose.q.cols() - first == 3) {
      out.row(k) << pose.q(k, first + 2), pose.q(k, first + 1), pose.q(k, first);
    } else {
      Eigen::Quaterniond turn(pose.q(k, first), pose.q(k, first + 1), pose.q(k, first + 2),
                              pose.q(k, first + 3));
      if (!(std::abs(turn.norm() - 1.0) < quaternion_tolerance)) {
        throw InputError(pose.place(k) + ": the quaternion of the base has the norm " + number(turn.norm()) +
                         ", must have 1; [log.base] orientation lists w, x, y, z");
      }
      turn.normalize();
      const Eigen::Matrix3d R = turn.toRotationMatrix();
      out.row(k) << std::atan2(R(1, 0), R(0, 0)), std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
          std::atan2(R(2, 1), R(2, 2));
    }
    if (!(std::abs(out(k, 1)) * degrees < steepest)) {
      throw InputError(pose.place(k) + ": the base is pitched by " + number(out(k, 1) * degrees, 3) +
                       "° at t = " + number(pose.t[k]) + " s, must keep within ±" + number(steepest) +
                       "°: at ±90° its yaw and roll can not be distinguished; cut the log before");
    }
    for (const Index c : {0, 2}) {
      constexpr double turn = 2.0 * std::numbers::pi;  // [rad]
      out(k, c) += k > 0 ? turn * std::round((out(k - 1, c) - out(k, c)) / turn) : 0.0;
    }
  }
  return out;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& yaw_pitch_roll) {
  return (Eigen::AngleAxisd(yaw_pitch_roll[0], Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(yaw_pitch_roll[1], Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(yaw_pitch_roll[2], Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

// Positions with the accelerations R f + g. No torque depends on where the base is, nor on a constant
// velocity of it, which is taken for zero at the start.
Matrix integrated(const Log& pose, const Matrix& turns, const Eigen::Vector3d& imu,
                  const Eigen::Vector3d& gravity) {
  Matrix out(pose.samples(), 3);
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (Index k = 0; k < pose.samples(); ++k) {
    const Eigen::Matrix3d R = rotation(turns.row(k).transpose());
    const Eigen::Vector3d a = R * pose.q.row(k).head<3>().transpose() + gravity;
    if (k > 0) {
      const double h = pose.t[k] - pose.t[k - 1];
      p += h * v + h * h / 6.0 * (2.0 * before + a);
      v += 0.5 * h * (before + a);
    }
    before = a;
    out.row(k) = (p - R * imu).transpose();
  }
  return out;
}

// The rows of the base are the data; constant torques count as not measured.
//
// throws InputError where nothing fixes the scale, or the drives have parameters
void take_no_torque(Log& log, const LogSource& source, const Robot& robot) {
  if (!robot.total_mass && source.contact.empty()) {
    throw InputError(log.source +
                     ": neither torque nor control signal; of a floating base the motion alone gives all "
                     "inertias but for one scale: name the columns of one of them or of contacts, or state "
                     "total_mass in [robot]");
  }
  for (auto j = static_cast<std::size_t>(robot.base_joints); j < robot.joints.size(); ++j) {
    if (robot.joints[j].friction != Friction::none || robot.joints[j].rotor_inertia) {
      throw InputError(
          log.source + ": neither torque nor control signal, which friction and rotor of joint \"" +
          robot.joints[j].name + "\" need: set friction = \"none\" and rotor_inertia = false in [robot]");
    }
  }
  log.tau = Matrix::Zero(log.samples(), robot.size() - robot.base_joints);
}

}  // namespace

Log with_base(Log log, const LogSource& source, const Robot& robot, const ColumnsRead& read) {
  if (!source.base) {
    return log;
  }
  if (log.tau.size() == 0 && log.v_tau.size() == 0) {
    take_no_torque(log, source, robot);
  }
  const LogSource::BasePose& base = *source.base;
  std::vector<Column> columns = base.position.empty() ? base.acceleration : base.position;
  columns.insert(columns.end(), base.orientation.begin(), base.orientation.end());
  const Log pose = columns_of(source, std::move(columns), read);
  const Matrix turns = angles(pose, 3);
  const Matrix places = base.position.empty() ? integrated(pose, turns, base.imu, robot.chain.gravity)
                                              : Matrix(pose.q.leftCols(3));
  const auto put = [&](Matrix& to, const Matrix& front) {
    if (to.size() > 0) {
      to = (Matrix(to.rows(), front.cols() + to.cols()) << front, to).finished();
    }
  };
  put(log.q, (Matrix(log.samples(), robot.base_joints) << places, turns).finished());
  put(log.tau, Matrix::Zero(log.samples(), robot.base_joints));
  put(log.v_tau, Matrix::Zero(log.samples(), robot.base_joints));
  for (Matrix Log::* const unused : {&Log::qd, &Log::q_r, &Log::qd_r}) {
    (log.*unused).resize(0, 0);
  }
  return log;
}

Log wrenches_of(const LogSource& source, const ColumnsRead& read) {
  std::vector<Column> columns;
  for (const LogSource::Contact& contact : source.contact) {
    columns.insert(columns.end(), contact.wrench.begin(), contact.wrench.end());
  }
  return columns_of(source, std::move(columns), read);
}

Log with_wrenches(Log log, const Log& wrenches, const LogSource& source, const Robot& robot) {
  require_independent("[log.contact]", robot.chain);
  log.tau = effort(robot, log);
  log.v_tau.resize(0, 0);
  const bool driven =
      !log.tau.rightCols(robot.size() - robot.base_joints).isZero(0.0);  // see take_no_torque()
  std::vector<LinkPose> poses(robot.chain.links.size());
  for (Index k = 0; k < log.samples(); ++k) {
    place_links(robot.chain, log.q.row(k).transpose(), poses);
    Index column = 0;
    for (const LogSource::Contact& contact : source.contact) {
      const std::size_t link = link_called(robot, contact.link).value();
      const Eigen::Matrix3d R = poses[link].R * link_axes(robot.chain.links[link]).transpose();
      const auto in_world = [&]() -> Eigen::Vector3d {
        const Eigen::Vector3d x = wrenches.q.row(k).segment<3>(column).transpose();
        column += 3;
        return contact.frame == LogSource::Contact::Frame::world ? x : Eigen::Vector3d(R * x);
      };
      const Eigen::Vector3d force = in_world();
      const Eigen::Vector3d moment = contact.wrench.size() == 6 ? in_world() : Eigen::Vector3d::Zero();
      const Eigen::Vector3d at = poses[link].o + R * contact.at;
      for (const std::size_t i : robot.chain.path(link)) {
        if (!driven && static_cast<Index>(i) >= robot.base_joints) {
          break;
        }
        const Eigen::Vector3d z = poses[i].R.col(2);
        log.tau(k, static_cast<Index>(i)) += robot.chain.links[i].type == JointType::revolute
                                                 ? z.dot(moment + (at - poses[i].o).cross(force))
                                                 : z.dot(force);
      }
    }
  }
  return log;
}

}  // namespace rivid::detail
