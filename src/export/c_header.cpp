#include "rivid/export/c_header.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <span>
#include <vector>

#include "export/c_online.hpp"
#include "export/joint_values.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::DynamicsLink;

// What follows the tables. @ is the robot's name.
constexpr std::string_view functions = R"(
/* Recursive Newton-Euler; qd, qdd: null for zeros. Without rotors and friction. */
static inline void @_newton_euler(const double* q, const double* qd, const double* qdd, double* tau) {
  double w[3] = {0.0, 0.0, 0.0};  /* angular velocity of the link at hand, in its own axes */
  double wd[3] = {0.0, 0.0, 0.0}; /* angular acceleration */
  double a[3] = {0.0, 0.0, 0.0};  /* acceleration of its origin, less that of free fall */
  double T[@_JOINTS][9];          /* orientation of frame j in frame j - 1, by rows */
  double p[@_JOINTS][3];          /* origin of frame j in frame j - 1 */
  double f[@_JOINTS][3];
  double m[@_JOINTS][3];
  int i, j, k;
  for (j = 0; j < @_JOINTS; ++j) {
    const double* const R = @_R[j];
    const double* const I = @_inertial[j];
    const double s = @_revolute[j] ? sin(q[j]) : 0.0;
    const double c = @_revolute[j] ? cos(q[j]) : 1.0;
    const double slide = @_revolute[j] ? 0.0 : q[j];
    const double rate = qd ? qd[j] : 0.0;
    const double rate_dot = qdd ? qdd[j] : 0.0;
    double point[3];
    double w0[3], wd0[3];
    double U[9];
    double Iw[3], Iwd[3];
    for (i = 0; i < 3; ++i) {
      T[j][3 * i] = R[3 * i] * c + R[3 * i + 1] * s;
      T[j][3 * i + 1] = R[3 * i + 1] * c - R[3 * i] * s;
      T[j][3 * i + 2] = R[3 * i + 2];
      p[j][i] = @_p[j][i] + R[3 * i + 2] * slide;
    }
    if (j == 0) {
      for (i = 0; i < 3; ++i) {
        point[i] = @_base_acceleration[i];
        w0[i] = 0.0;
        wd0[i] = 0.0;
      }
    } else {
      const double* const r = p[j];
      const double wr = w[0] * r[0] + w[1] * r[1] + w[2] * r[2];
      const double ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
      point[0] = a[0] + wd[1] * r[2] - wd[2] * r[1] + w[0] * wr - r[0] * ww;
      point[1] = a[1] + wd[2] * r[0] - wd[0] * r[2] + w[1] * wr - r[1] * ww;
      point[2] = a[2] + wd[0] * r[1] - wd[1] * r[0] + w[2] * wr - r[2] * ww;
      for (i = 0; i < 3; ++i) {
        w0[i] = w[i];
        wd0[i] = wd[i];
      }
    }
    for (i = 0; i < 3; ++i) {
      a[i] = T[j][i] * point[0] + T[j][3 + i] * point[1] + T[j][6 + i] * point[2];
      w[i] = T[j][i] * w0[0] + T[j][3 + i] * w0[1] + T[j][6 + i] * w0[2];
      wd[i] = T[j][i] * wd0[0] + T[j][3 + i] * wd0[1] + T[j][6 + i] * wd0[2];
    }
    if (@_revolute[j]) {
      wd[0] += w[1] * rate;
      wd[1] -= w[0] * rate;
      wd[2] += rate_dot;
      w[2] += rate;
    } else {
      a[0] += 2.0 * w[1] * rate;
      a[1] -= 2.0 * w[0] * rate;
      a[2] += rate_dot;
    }
    U[0] = -w[1] * w[1] - w[2] * w[2];
    U[1] = w[0] * w[1] - wd[2];
    U[2] = w[0] * w[2] + wd[1];
    U[3] = w[0] * w[1] + wd[2];
    U[4] = -w[0] * w[0] - w[2] * w[2];
    U[5] = w[1] * w[2] - wd[0];
    U[6] = w[0] * w[2] - wd[1];
    U[7] = w[1] * w[2] + wd[0];
    U[8] = -w[0] * w[0] - w[1] * w[1];
    for (i = 0; i < 3; ++i) {
      f[j][i] = I[9] * a[i] + U[3 * i] * I[6] + U[3 * i + 1] * I[7] + U[3 * i + 2] * I[8];
    }
    Iw[0] = I[0] * w[0] + I[1] * w[1] + I[2] * w[2];
    Iw[1] = I[1] * w[0] + I[3] * w[1] + I[4] * w[2];
    Iw[2] = I[2] * w[0] + I[4] * w[1] + I[5] * w[2];
    Iwd[0] = I[0] * wd[0] + I[1] * wd[1] + I[2] * wd[2];
    Iwd[1] = I[1] * wd[0] + I[3] * wd[1] + I[4] * wd[2];
    Iwd[2] = I[2] * wd[0] + I[4] * wd[1] + I[5] * wd[2];
    m[j][0] = Iwd[0] + w[1] * Iw[2] - w[2] * Iw[1] + I[7] * a[2] - I[8] * a[1];
    m[j][1] = Iwd[1] + w[2] * Iw[0] - w[0] * Iw[2] + I[8] * a[0] - I[6] * a[2];
    m[j][2] = Iwd[2] + w[0] * Iw[1] - w[1] * Iw[0] + I[6] * a[1] - I[7] * a[0];
  }
  for (j = @_JOINTS - 1; j >= 0; --j) {
    tau[j] = @_revolute[j] ? m[j][2] : f[j][2];
    if (j > 0) {
      double g[3];
      for (i = 0; i < 3; ++i) {
        g[i] = 0.0;
        for (k = 0; k < 3; ++k) {
          g[i] += T[j][3 * i + k] * f[j][k];
          m[j - 1][i] += T[j][3 * i + k] * m[j][k];
        }
        f[j - 1][i] += g[i];
      }
      m[j - 1][0] += p[j][1] * g[2] - p[j][2] * g[1];
      m[j - 1][1] += p[j][2] * g[0] - p[j][0] * g[2];
      m[j - 1][2] += p[j][0] * g[1] - p[j][1] * g[0];
    }
  }
}

/* M(q) qdd + N(q, qd): inertia, rotors, Coriolis, centrifugal and gravity torques. */
static inline void @_rigid_body(const double q[@_JOINTS], const double qd[@_JOINTS], const double qdd[@_JOINTS],
                                double tau[@_JOINTS]) {
  int i, j;
  @_newton_euler(q, qd, qdd, tau);
  for (i = 0; i < @_JOINTS; ++i) {
    for (j = 0; j < @_JOINTS; ++j) {
      tau[i] += @_rotor[i][j] * qdd[j];
    }
  }
}

/* N(q, 0): what holds the robot against gravity. */
static inline void @_gravity(const double q[@_JOINTS], double tau[@_JOINTS]) {
  @_newton_euler(q, (const double*)0, (const double*)0, tau);
}

/* Friction. smoothing_speed: null for sign(qd), 0 at rest; else v_s of each joint, positive, of tanh(qd / v_s). What was
   identified with a smooth sign keeps its own. */
static inline void @_friction(const double qd[@_JOINTS], const double* smoothing_speed, double tau[@_JOINTS]) {
  int i, j, e;
  for (i = 0; i < @_JOINTS; ++i) {
    tau[i] = @_offset[i];
    for (j = 0; j < @_JOINTS; ++j) {
      tau[i] += @_viscous[i][j] * qd[j];
    }
  }
  for (e = 0; e < @_dry_count; ++e) {
    const double own = @_dry_sign_speed[e];
    double speed = 0.0, v_s = 0.0, forward, backward, lambda;
    for (j = 0; j < @_JOINTS; ++j) {
      const double c = @_dry_direction[e][j];
      speed += c * qd[j];
      v_s += smoothing_speed ? (c < 0.0 ? -c : c) * smoothing_speed[j] : 0.0;
    }
    forward = v_s > 0.0 ? 0.5 + 0.5 * tanh(speed / v_s) : (speed > 0.0 ? 1.0 : 0.0);
    backward = v_s > 0.0 ? 1.0 - forward : (speed < 0.0 ? 1.0 : 0.0);
    lambda = own > 0.0 ? @_dry(e, speed > 0.0, speed, tanh(speed / own))
                       : @_dry(e, 1, speed, 1.0) * forward + @_dry(e, 0, speed, -1.0) * backward;
    lambda += @_by_speed(e, speed > 0.0, speed);
    for (i = 0; i < @_JOINTS; ++i) {
      tau[i] += @_dry_torque[e][i] * lambda;
    }
  }
}

/* tau = M(q) qdd + N(q, qd) + friction(qd), with the sign of qd as it is. Friction that follows the load, of which a joint
   takes _load |M(q) qdd + N(q, qd)|, is here alone. */
static inline void @_inverse_dynamics(const double q[@_JOINTS], const double qd[@_JOINTS],
                                      const double qdd[@_JOINTS], double tau[@_JOINTS]) {
  double friction[@_JOINTS];
  int i;
  int e;
  @_rigid_body(q, qd, qdd, tau);
  @_friction(qd, (const double*)0, friction);
  for (e = 0; e < @_dry_count; ++e) {
    const double own = @_dry_sign_speed[e];
    for (i = 0; @_dry_load[e] > 0.0 && i < @_JOINTS; ++i) {
      if (@_dry_torque[e][i] != 0.0) {
        const double sign = own > 0.0 ? tanh(qd[i] / own) : qd[i] > 0.0 ? 1.0 : qd[i] < 0.0 ? -1.0 : 0.0;
        friction[i] += @_dry_load[e] * fabs(tau[i]) * sign;
      }
    }
  }
  for (i = 0; i < @_JOINTS; ++i) {
    tau[i] += friction[i];
  }
}
)";

std::string row(std::span<const double> values) {
  std::string out = "{";
  for (const double value : values) {
    out.append(out.size() > 1 ? ", " : "").append(exact(value));
  }
  return out + "}";
}

std::string row(const Vector& values) {
  return row(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

std::string table(std::string_view type_and_name, const std::vector<std::string>& rows) {
  std::string out = "static const " + std::string(type_and_name) + " = {";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.append(i > 0 ? "," : "").append("\n    ").append(rows[i]);
  }
  return out + "};\n";
}

std::vector<std::string> rows_of(const Matrix& x) {
  std::vector<std::string> out;
  out.reserve(static_cast<std::size_t>(x.rows()));
  for (Index i = 0; i < x.rows(); ++i) {
    out.push_back(row(Vector(x.row(i))));
  }
  return out;
}

// R Rz(θ), by rows: what the kernels of rivid do in two steps.
std::string rotation(const DynamicsLink& link) {
  std::vector<double> out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = link.R[3 * i];
    const double y = link.R[3 * i + 1];
    out.insert(out.end(), {x * link.cos_theta + y * link.sin_theta, y * link.cos_theta - x * link.sin_theta,
                           link.R[3 * i + 2]});
  }
  return row(out);
}

// Acceleration of the base in its own axes.
std::vector<double> base_acceleration(const detail::DynamicsTables& tables) {
  const DynamicsLink& link = tables.links.front();
  const Eigen::Vector3d turned =
      Eigen::Map<const Eigen::Matrix3d>(link.R).transpose() * Eigen::Vector3d(tables.accel.data());
  return {turned.begin(), turned.end()};
}

std::string link_tables(const DynamicModel& model) {
  const detail::DynamicsTables tables(model);
  std::vector<std::string> R, p, inertial;
  std::string revolute;
  for (const DynamicsLink& link : tables.links) {
    R.push_back(rotation(link));
    p.push_back(row(link.p));
    inertial.push_back(row(link.inertial));
    revolute += (revolute.empty() ? "" : ", ") + std::string(link.revolute ? "1" : "0");
  }
  return "/* Orientation (by rows) and origin of frame j in frame j - 1, z along the axis of joint j. */\n" +
         table("double @_R[@_JOINTS][9]", R) + table("double @_p[@_JOINTS][3]", p) +
         "static const int @_revolute[@_JOINTS] = {" + revolute + "};\n" +
         "/* XX XY XZ YY YZ ZZ MX MY MZ M about the origin of frame j. */\n" +
         table("double @_inertial[@_JOINTS][10]", inertial) +
         "/* Of the base, less that of free fall. */\nstatic const double @_base_acceleration[3] = " +
         row(base_acceleration(tables)) + ";\n" +
         "/* Orientation of the last frame in the frame of the last link. */\n" +
         table("double @_last_axes[3][3]", rows_of(link_axes(model.chain().links.back())));
}

// Σ c φ over the functions of dry friction, or over the others.
std::string friction_sum(std::span<const BasisRow> phi, bool dry) {
  std::string out;
  for (std::size_t k = 0; k < phi.size(); ++k) {
    if ((phi[k].role == Role::dry) == dry) {
      out.append(out.empty() ? "" : " + ").append("c[" + std::to_string(k) + "] * (");
      out.append(phi[k].in_c).append(")");
    }
  }
  return out.empty() ? "0.0 * c[0]" : out;
}

// Coefficients of an element by function, of one direction.
Vector coefficients(const DryFriction& element, std::span<const BasisRow> phi,
                    double DryFriction::Term::* direction) {
  Vector out = Vector::Zero(static_cast<Index>(phi.size()));
  for (const DryFriction::Term& term : element.terms) {
    out[std::ranges::find(phi, term.basis, &BasisRow::basis) - phi.begin()] = term.*direction;
  }
  return out;
}

std::string friction_tables(const DynamicModel& model) {
  std::vector<BasisRow> phi;
  std::ranges::copy_if(basis_rows, std::back_inserter(phi), [](const BasisRow& row) {
    return row.basis != Basis::load && (row.role == Role::dry || row.role == Role::viscous);
  });
  std::vector<std::string> direction, torque, law;
  std::vector<double> sign_speed, load;
  for (const DryFriction& element : model.dry_friction()) {
    direction.push_back(row(element.direction));
    torque.push_back(row(element.torque));
    law.push_back("{" + row(coefficients(element, phi, &DryFriction::Term::minus)) + ", " +
                  row(coefficients(element, phi, &DryFriction::Term::plus)) + "}");
    sign_speed.push_back(element.sign_speed);
    load.push_back(element.load);
  }
  const std::string count = std::to_string(law.size());
  if (law.empty()) {  // C has no arrays of nothing
    const Vector none = Vector::Zero(static_cast<Index>(phi.size()));
    direction.push_back(row(Vector(Vector::Zero(model.size()))));
    torque = direction;
    law.push_back("{" + row(none) + ", " + row(none) + "}");
    sign_speed.push_back(0.0);
    load.push_back(0.0);
  }
  const std::string length = "[" + std::to_string(law.size()) + "]";
  return "/* Friction that depends on the sign of a velocity: speed = direction . qd. */\nenum { @_dry_count "
         "= " +
         count + " };\n" + table("double @_dry_direction" + length + "[@_JOINTS]", direction) +
         table("double @_dry_torque" + length + "[@_JOINTS]", torque) +
         "/* v_s of tanh(speed / v_s), where friction was identified smooth. */\nstatic const double "
         "@_dry_sign_speed" +
         length + " = " + row(sign_speed) +
         ";\n/* Friction by load: part of the torque M(q) qdd + N(q, qd) of its joint. */\nstatic const "
         "double "
         "@_dry_load" +
         length + " = " + row(load) +
         ";\n/* Coefficients while the speed is negative, and while it is positive. */\n" +
         table("double @_dry_law" + length + "[2][" + std::to_string(phi.size()) + "]", law) +
         "\n/* What follows the sign of the speed, which may be smooth. */\n"
         "static inline double @_dry(int e, int plus, double speed, double sign) {\n"
         "  const double* const c = @_dry_law[e][plus];\n  (void)speed;\n  return " +
         friction_sum(phi, true) +
         ";\n}\n/* What follows the speed. */\n"
         "static inline double @_by_speed(int e, int plus, double speed) {\n"
         "  const double* const c = @_dry_law[e][plus];\n  const double sign = plus ? 1.0 : -1.0;\n"
         "  (void)sign;\n  return " +
         friction_sum(phi, false) + ";\n}\n";
}

// A text that can stand in a comment.
std::string commented(std::string_view text) {
  std::string out = on_one_line(text);
  for (std::size_t at = out.find("*/"); at != std::string::npos; at = out.find("*/")) {
    out.replace(at, 2, "* /");
  }
  return out;
}

bool is_identifier(std::string_view text) { return !text.empty() && c_identifier(text) == text; }

}  // namespace

std::string c_identifier(std::string_view text) {
  std::string out(text);
  const auto is_ascii = [](unsigned char c) { return c < 128 && (std::isalnum(c) != 0 || c == '_'); };
  std::ranges::replace_if(out, [&](char c) { return !is_ascii(static_cast<unsigned char>(c)); }, '_');
  const bool digit = !out.empty() && out.front() >= '0' && out.front() <= '9';
  return digit ? "_" + out : out;
}

std::string c_header(const DynamicModel& model, std::string_view name, std::string_view origin) {
  if (!is_identifier(name)) {
    throw InputError("c_header: name is " + in_quotes(name) +
                     ", must be a C identifier: letters, digits and _, no digit first");
  }
  std::string joints;
  for (const Joint& joint : model.joints()) {
    joints.append(joints.empty() ? "" : ", ").append(joint.name);
  }
  const std::string body = "#ifndef RIVID_@_H\n#define RIVID_@_H\n\n#include <math.h>\n\n#define @_JOINTS " +
                           std::to_string(model.size()) + "\n\n" + link_tables(model) +
                           "/* What rotors add to the mass matrix. */\n" +
                           table("double @_rotor[@_JOINTS][@_JOINTS]", rows_of(model.rotor())) +
                           table("double @_viscous[@_JOINTS][@_JOINTS]", rows_of(model.viscous())) +
                           "static const double @_offset[@_JOINTS] = " + row(model.offset()) + ";\n" +
                           friction_tables(model) + std::string(functions) +
                           std::string(detail::c_online_functions) + "\n#endif\n";
  std::string out = "/* Torques of a robot, written by rivid" +
                    (origin.empty() ? std::string() : ": " + commented(origin)) +
                    ".\n * Joints: " + commented(joints) +
                    ".\n * SI units on the joint side: q [rad | m], qd, qdd by seconds, tau [N m | N]. */\n";
  for (const char c : body) {
    if (c == '@') {
      out += name;
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace rivid
