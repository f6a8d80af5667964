#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/chain.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/model/parameters.hpp"

namespace rivid {

template <>
inline constexpr std::array names_of<Friction> = [] {
  std::array<std::string_view, friction_rows.size()> out = {};
  for (const FrictionRow& row : friction_rows) {
    out[static_cast<std::size_t>(row.law)] = row.name;
  }
  return out;
}();

/// A motor that several joints turn, as in the wrists of many arms: the motor of joint m runs at
///
///   q̇_m + Σ_k ratio_k q̇_k = cᵀ q̇        (joint side: c_m = 1)
///
/// and loads all of these joints with its rotor inertia and its friction,
///
///   τ += c (Iam cᵀ q̈ + Fvm cᵀ q̇ + Fcm sign(cᵀ q̇)).
///
/// Beside joints that have an inertia Ia_i and a friction Fv_i of their own, the diagonal of c cᵀ is no news:
/// Ia_i + c_i² Iam is all that the torque of joint i shows. With Terms::cross, the default, Iam and Fvm
/// therefore stand for the entries off the diagonal alone, and Ia_i, Fv_i hold c_i² Iam, c_i² Fvm. With
/// Terms::all they stand for the whole of c cᵀ. Either way the model reaches the same torques; the values of
/// Iam and Fvm are the same, those of Ia_i and Fv_i differ by that diagonal. Coulomb friction has no such
/// choice: sign(cᵀ q̇) is no sum over joints, and its column is always whole.
///
/// The other reading in use (BIRDy's TX40) ties the coupled inertia to Ia_m and takes the signs of the single
/// velocities: Inertia::tied, Coulomb::single.
struct Coupling {
  /// Whose parameter the coupled inertia is.
  enum class Inertia {
    none,  ///< the motor's inertia is not modelled
    free,  ///< Iam, a parameter of its own
    tied   ///< Ia of joint m: its column gets the coupling terms as well
  };
  /// Velocity whose sign the coupled Coulomb friction has.
  enum class Coulomb {
    none,
    sum,    ///< of the motor: τ_i += Fcm c_i sign(cᵀ q̇)
    single  ///< of each joint alone: τ_i += Fcm Σ_k c_i sign(c_k q̇_k), with Terms::cross over k ≠ i
  };
  /// Entries of c cᵀ that the coupled parameters stand for.
  enum class Terms {
    cross,  ///< those off the diagonal; the joints' own Ia, Fv, Fc hold the others
    all
  };

  int motor = 0;               ///< joint m, counted from 0, that this motor is named after
  std::vector<int> joints;     ///< the other joints that turn it, counted from 0
  std::vector<double> ratios;  ///< c_k of `joints`: unit of joint m per unit of joint k; not zero
  Inertia inertia = Inertia::free;
  bool viscous = true;  ///< whether Fvm is a parameter
  Coulomb coulomb = Coulomb::sum;
  Terms terms = Terms::cross;

  double Iam = 0.0;  ///< a-priori values, unused where they are no parameters [kg·m² | kg]
  double Fvm = 0.0;  ///< [N·m·s/rad | N·s/m]
  double Fcm = 0.0;  ///< [N·m | N]

  /// c, (n) [unit of joint m per unit of the joint].
  [[nodiscard]] Vector row(Index n) const;

  /// The coupled parameters that this coupling adds to the standard ones of joint m: Iam, Fvm, Fcm.
  [[nodiscard]] std::vector<ParameterKind> parameters() const;

  template <typename C = Coupling>
  static constexpr auto fields() {
    constexpr std::string_view named =
        "must name motor and joints: { motor = \"joint_6\", joints = [\"joint_5\"] }";
    return std::tuple(
        Field{"motor", Key<std::string>(), "joint m that the motor is named after", {.required = named}},
        Field{
            "joints", Key<std::vector<std::string>>(), "the other joints that turn it", {.required = named}},
        Field{"ratios",
              &C::ratios,
              "c_k of `joints`",
              {.otherwise = "`1` each", .unit = "unit of joint m per unit of the joint"}},
        Field{"inertia", &C::inertia,
              "`\"free\"`: Iam is a parameter; `\"tied\"`: Ia of joint m is; `\"none\"`"},
        Field{"viscous", &C::viscous, "whether Fvm is a parameter"},
        Field{"coulomb", &C::coulomb,
              "`\"sum\"`: sign of cᵀq̇; `\"single\"`: signs of the single q̇_k; `\"none\"`"},
        Field{"terms", &C::terms,
              "`\"cross\"`: off the diagonal of c cᵀ, which is left to Ia and Fv of the joints; `\"all\"`"});
  }
  /// A-priori values, which a result reports with its parameters.
  template <typename C = Coupling>
  static constexpr auto a_priori() {
    return std::tuple(Field{"Iam", &C::Iam, "a-priori inertia", {.unit = "kg·m² or kg"}},
                      Field{"Fvm", &C::Fvm, "a-priori viscous friction", {.unit = "N·m·s/rad or N·s/m"}},
                      Field{"Fcm", &C::Fcm, "a-priori Coulomb friction", {.unit = "N·m or N"}});
  }
};

/// What one coupled parameter is multiplied with in the torque of one joint.
struct CoupledEntry {
  enum class Quantity {
    acceleration,   ///< Σ_k weight_k q̈_k
    velocity,       ///< Σ_k weight_k q̇_k
    single_signs,   ///< Σ_k weight_k sign(q̇_k)
    sign_of_motion  ///< scale sign(Σ_k weight_k q̇_k)
  };
  struct Term {
    std::size_t joint = 0;
    double weight = 0.0;
    double sign_speed = 0.0;  ///< of single_signs: Joint::sign_speed
  };

  std::size_t joint = 0;  ///< whose torque it is in
  Quantity quantity = Quantity::acceleration;
  double scale = 1.0;
  std::vector<Term> terms;
  double sign_speed = 0.0;  ///< of sign_of_motion: Joint::sign_speed of the motor's joint
};

/// Regressor entries of a coupled parameter, one for each joint that feels it, in the order of the joints.
///
/// @param kind  Iam, Fvm, Fcm; or Ia of a coupling with Inertia::tied
/// @param n     joints of the robot
[[nodiscard]] std::vector<CoupledEntry> coupled_entries(const Coupling& coupling, ParameterKind kind,
                                                        Index n);

/// C of q̇_motor = C q̇: the rows c of the couplings, and those of the identity for all other motors, (n ×
/// n).
[[nodiscard]] Matrix coupling_matrix(std::span<const Coupling> couplings, Index n);

template <>
inline constexpr std::array names_of<Coupling::Inertia> =
    std::to_array<std::string_view>({"none", "free", "tied"});
template <>
inline constexpr std::array names_of<Coupling::Coulomb> =
    std::to_array<std::string_view>({"none", "sum", "single"});
template <>
inline constexpr std::array names_of<Coupling::Terms> = std::to_array<std::string_view>({"cross", "all"});

/// What a joint is beside its geometry: names, drive, friction law, limits and a-priori values.
struct Joint {
  std::string name;  ///< of the joint
  std::string link;  ///< that it moves
  JointType type = JointType::revolute;

  Friction friction = Friction::symmetric;
  /// Where it is not 0, Coulomb friction is smooth at reversals: tanh(q̇ / sign_speed) takes the place of
  /// sign q̇, in the regressor and in the dynamics, and nothing sticks [rad/s | m/s].
  double sign_speed = 0.0;
  bool rotor_inertia = true;  ///< whether Ia of this joint is a parameter
  /// Force or torque per unit of the control signal on the motor's side of the gear: K_c K_τ of Eq. (9) of
  /// [RIV].
  double drive_gain = 1.0;
  double gear_ratio = 1.0;  ///< K_r of Eq. (9): q̇_m = K_r q̇; see Robot::gear_matrix for coupled gears

  double lower = -std::numeric_limits<double>::infinity();  ///< position limits [rad | m]
  double upper = std::numeric_limits<double>::infinity();
  double max_velocity = std::numeric_limits<double>::infinity();  ///< [rad/s | m/s]
  double max_effort = std::numeric_limits<double>::infinity();    ///< [N·m | N]

  double Ia = 0.0;  ///< a-priori rotor and gear inertia, joint side [kg·m² | kg]
  double Fv = 0.0;  ///< a-priori viscous friction [N·m·s/rad | N·s/m]
  double Fc = 0.0;  ///< a-priori Coulomb friction [N·m | N]

  /// Twin of this joint, empty for none: identify() ties rotor inertia, friction (but for `off`) and the body
  /// of the link to those of the joint of that name.
  std::string same_as = {};
  /// Signs ±1 of the axes of the link's frame, in which the twin's body becomes this one; empty: by the
  /// geometry, at q = 0.
  std::vector<int> mirror = {};

  /// g_τ of Eqs. (8, 9): joint-side torque per unit of the control signal.
  [[nodiscard]] double g_tau() const { return gear_ratio * drive_gain; }

  template <typename J = Joint>
  static constexpr auto fields() {
    return std::tuple(
        Field{"friction", &J::friction,
              "friction law, see [below](#friction-laws); `\"auto\"` chooses it by cross-validation, see "
              "[friction](friction.md)"},
        Field{"sign_speed",
              &J::sign_speed,
              "if not 0, tanh(q̇ / sign_speed) replaces sign q̇, and nothing sticks: for data that were "
              "simulated so",
              {.unit = "rad/s, m/s"}},
        Field{"rotor_inertia", &J::rotor_inertia,
              "whether there is Ia, τ += Ia q̈; `false` behind joint torque sensors and for direct drives"},
        Field{"drive_gain",
              &J::drive_gain,
              "K_c K_τ of (9), for `control`",
              {.unit = "N·m or N a unit of the control signal, on the motor's side of the gear"}},
        Field{"gear_ratio", &J::gear_ratio, "K_r of (9). g_τ = gear_ratio × drive_gain, τ = g_τ v_τ (8)."});
  }
  /// A-priori values, which a result reports with its parameters.
  template <typename J = Joint>
  static constexpr auto a_priori() {
    return std::tuple(
        Field{"Ia", &J::Ia, "a-priori inertia of rotor and gears, joint side", {.unit = "kg·m² or kg"}},
        Field{"Fv",
              &J::Fv,
              "a-priori viscous friction",
              {.otherwise = "URDF `damping`, else 0", .unit = "N·m·s/rad or N·s/m"}},
        Field{"Fc",
              &J::Fc,
              "a-priori Coulomb friction",
              {.otherwise = "URDF `friction`, else 0", .unit = "N·m or N"}});
  }
  /// What ties it to another joint.
  template <typename J = Joint>
  static constexpr auto twin() {
    return std::tuple(
        Field{"same_as",
              &J::same_as,
              "twin: joint whose parameters it shares, see [below](#twins)",
              {.otherwise = "–"}},
        Field{"mirror",
              &J::mirror,
              "of the twin: signs of the axes of the link's frame, `[1, -1, 1]` for a reflection in y",
              {.otherwise = "by the geometry", .range = Range::within(-1, 1)}});
  }
};

/// How well the geometry of a description is known: standard deviations, which the covariance of an estimate
/// then contains. Zero: exactly.
struct GeometryTolerance {
  double length = 0.0;  ///< of each coordinate of a joint's origin in the frame before it [m]
  double angle = 0.0;   ///< of a joint's zero and of each turn of its axis [rad]

  template <typename T = GeometryTolerance>
  static constexpr auto fields() {
    return std::tuple(Field{"length",
                            &T::length,
                            "standard deviation of each coordinate of a joint's origin",
                            {.unit = "m", .range = Range::from(0.0, 1.0)}},
                      Field{"angle",
                            &T::angle,
                            "standard deviation of a joint's zero and of each turn of its axis",
                            {.unit = "rad", .range = Range::from(0.0, 1.0)}});
  }
};

/// A robot: its chain or tree, its joints and the a-priori inertial parameters of its links.
///
/// Made by read_urdf(), from a KDL::Chain or from a modified Denavit-Hartenberg table; options of the joints
/// may then be changed. A robot is only read by the functions that take it, so threads may share one.
struct Robot {
  std::string name;
  std::string base;  ///< link that stands still
  Chain chain;
  std::vector<Joint> joints;        ///< those that move by themselves, without Chain::dependents
  std::vector<Inertial> inertials;  ///< a-priori values of all links, in their frames; zero where unknown
  std::vector<Coupling> couplings;  ///< motors that several joints turn, and their parameters
  /// R of q_motor = R q, (n × n), where gears couple the joints; empty: the diagonal of the gear ratios. By
  /// the balance of power the motors' torques act on the joints through its transpose, τ = Rᵀ τ_motor. It
  /// converts logs and control signals; which parameters the coupling adds to the model is said by
  /// `couplings`.
  Matrix gear_matrix;
  /// Parameters count as one where their columns of the regressor differ by less than this fraction of the
  /// largest column of the same unit, between 0 and 1. Angles that are written with few digits distinguish
  /// parameters that the robot does not: 1.5708 for π/2 by some 1e-6, 1.57 by some 2e-4. What geometry
  /// distinguishes is a few hundredths.
  double base_tolerance = 1e-5;
  GeometryTolerance tolerance;
  /// 6 on a floating base, else 0. The first six joints are then those of its pose in the world: x, y, z,
  /// yaw, pitch, roll. No drive moves them, and the links between them have no body.
  Index base_joints = 0;
  /// Of all links that a floating base carries, where it is known: it fixes the scale where no torque is
  /// measured, see known_mass() [kg].
  std::optional<double> total_mass = {};
  std::vector<Finding> warnings;   ///< what the reader noticed and the user should know
  std::vector<std::string> notes;  ///< what was chosen for it

  /// n, without dependent joints.
  [[nodiscard]] Index size() const { return chain.joints(); }

  /// The first link that has a body, counted from 0: all behind it have one.
  [[nodiscard]] Index first_body() const { return std::max<Index>(base_joints - 1, 0); }

  /// Whether a parameter is total_mass: M of the root.
  [[nodiscard]] bool known_mass(const StandardParameter& p) const {
    return total_mass && p.kind == ParameterKind::M && p.joint == first_body();
  }

  /// Name of link j, counted from 0, those of dependent joints last.
  [[nodiscard]] const std::string& link_name(std::size_t j) const {
    return j < joints.size() ? joints[j].link : chain.dependents[j - joints.size()].link;
  }

  /// The link that a joint moves, counted from 0, dependent joints among them; nothing for a name of none.
  [[nodiscard]] std::optional<std::size_t> link_of(std::string_view joint) const;

  /// The standard parameters that this robot has, link by link: XX … M, then Ia where the joint has a rotor
  /// inertia, then those of its friction law (at most 16 a link), then those of its motor's coupling. Links
  /// of dependent joints have the first ten alone, those before first_body() none.
  [[nodiscard]] std::vector<StandardParameter> standard_parameters() const;

  /// A-priori values of standard_parameters(), (N_s) [SI, joint side]: chi_st of Eq. (2) of [RIV].
  [[nodiscard]] Vector chi_st() const;

  /// R of q_motor = R q: gear_matrix, or the diagonal of the gear ratios, (n × n).
  [[nodiscard]] Matrix gears() const;

  /// G of τ = G v_τ, Eqs. (8, 9) of [RIV] for coupled gears: Rᵀ diag(drive_gain), (n × n). Without a
  /// gear_matrix it is the diagonal of Joint::g_tau().
  [[nodiscard]] Matrix drive_matrix() const;

  /// The first fault found, in words that name the joint; nothing if the robot can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

}  // namespace rivid

#ifdef RIVID_DEFINITIONS
#include "rivid/model/robot_inline.hpp"
#endif
