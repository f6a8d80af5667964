#include "binding.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "rivid/text.hpp"

namespace rivid::python {

namespace {

// Rows of several series that belong together.
void require_shape(const char* what, const Matrix& x, Index rows, Index columns) {
  if (x.rows() != rows || x.cols() != columns) {
    throw InputError(std::string(what) + " is " + std::to_string(x.rows()) + " × " +
                     std::to_string(x.cols()) + ", must be " + std::to_string(rows) + " × " +
                     std::to_string(columns) + ": one row a sample, one column a joint");
  }
}

// A function of the rows of three series, row by row.
template <typename Function>
Matrix row_by_row(Index n, const Matrix& q, const Matrix& second, const Matrix& third,
                  const Function& function) {
  require_shape("q", q, q.rows(), n);
  require_shape("the second series", second, q.rows(), n);
  require_shape("the third series", third, q.rows(), n);
  Matrix out(q.rows(), n);
  for (Index k = 0; k < q.rows(); ++k) {
    out.row(k) = function(Vector(q.row(k)), Vector(second.row(k)), Vector(third.row(k)));
  }
  return out;
}

void bind_base(nb::module_& m) {
  nb::class_<BaseParameters> base(m, "BaseParameters", "Base parameters of a robot (4–6).");
  const auto texts = [](std::string BaseParameter::* member) {
    return [member](const BaseParameters& self) {
      std::vector<std::string> out;
      for (const BaseParameter& p : self.parameters) {
        out.push_back(p.*member);
      }
      return out;
    };
  };
  base.def(
          "__init__",
          [](BaseParameters* self, const Robot& robot) { new (self) BaseParameters(base_parameters(robot)); },
          "robot"_a)
      .def("__len__", &BaseParameters::size)
      .def_prop_ro("names", texts(&BaseParameter::name))
      .def_prop_ro("units", texts(&BaseParameter::unit))
      .def_prop_ro("regrouped", texts(&BaseParameter::regrouped))
      .def_prop_ro("rank_gap", &BaseParameters::rank_gap)
      .def_prop_ro("doubt", &BaseParameters::doubt)
      .def("regrouping", &BaseParameters::regrouping, "i"_a)
      .def(
          "from_standard", [](const BaseParameters& self, const Vector& x) { return self.from_standard(x); },
          "chi_st"_a)
      .def(
          "to_standard", [](const BaseParameters& self, const Vector& x) { return self.to_standard(x); },
          "chi"_a)
      .def("null_space", &BaseParameters::null_space);
  m.def(
      "observation",
      [](const Robot& robot, const BaseParameters& parameters, const Matrix& q, const Matrix& qd,
         const Matrix& qdd,
         int threads) { return observation(robot, parameters, {q, qd, qdd}, {.threads = threads}).dense(); },
      "robot"_a, "base"_a, "q"_a, "qd"_a, "qdd"_a, "threads"_a = 1, Unlocked(),
      "W of (10–12): rows joint by joint, one column a base parameter.");
  m.def("read_parameters", &read_parameters, "path"_a, "base"_a, Unlocked(),
        "Standard parameters of a parameter file.");
}

// For each name of an argument.
template <typename Name>
using VectorOf = Vector;

void bind_model(nb::module_& m) {
  nb::class_<DynamicModel>(m, "DynamicModel", "A robot with numbers for its parameters.")
      .def(
          "__init__",
          [](DynamicModel* self, const Robot& robot, const Vector& chi_st) {
            new (self) DynamicModel(robot, chi_st);
          },
          "robot"_a, "chi_st"_a)
      .def_static(
          "of_base",
          [](const Robot& robot, const BaseParameters& base, const Vector& chi) {
            return DynamicModel(robot, base, chi);
          },
          "robot"_a, "base"_a, "chi"_a)
      .def_static(
          "of_result",
          [](const std::filesystem::path& path, const std::string& parameters, bool force) {
            return read_identified_model(
                path, {.parameters = parameters.empty()         ? std::nullopt
                                     : parameters == "physical" ? std::optional(ParameterSet::physical)
                                                                : std::optional(ParameterSet::estimate),
                       .force = force});
          },
          "path"_a, "parameters"_a = "", "force"_a = false)
      .def_prop_ro("size", &DynamicModel::size)
      .def_prop_ro("joint_names",
                   [](const DynamicModel& self) {
                     std::vector<std::string> out;
                     for (const Joint& joint : self.joints()) {
                       out.push_back(joint.name);
                     }
                     return out;
                   })
      .def_prop_ro("clamped", &DynamicModel::clamped)
      .def(
          "mass_matrix", [](const DynamicModel& self, const Vector& q) { return mass_matrix(self, q); },
          "q"_a)
      .def(
          "inverse_dynamics",
          [](const DynamicModel& self, const Matrix& q, const Matrix& qd, const Matrix& qdd) {
            InverseDynamics dynamics(self);
            Vector tau(self.size());
            return row_by_row(self.size(), q, qd, qdd,
                              [&](const Vector& a, const Vector& b, const Vector& c) -> const Vector& {
                                dynamics.torque(a, b, c, tau);
                                return tau;
                              });
          },
          "q"_a, "qd"_a, "qdd"_a, Unlocked())
      .def(
          "direct_dynamics",
          [](const DynamicModel& self, const Matrix& q, const Matrix& qd, const Matrix& tau) {
            return row_by_row(self.size(), q, qd, tau,
                              [&](const Vector& a, const Vector& b, const Vector& c) {
                                return direct_dynamics(self, a, b, c);
                              });
          },
          "q"_a, "qd"_a, "tau"_a, Unlocked());
  // For loops: a size that is wrong gives numbers that are none, as in C++; the package checks them.
  nb::class_<InverseDynamics> dynamics(m, "InverseDynamics", "Torques for the loop of a controller.");
  const auto def_torques = [&](const char* name, auto torques, auto... arguments) {
    dynamics.def(
        name,
        [torques](InverseDynamics& self, const VectorOf<decltype(arguments)>&... x) {
          Vector out(self.size());
          torques(self, x..., out);
          return out;
        },
        arguments...);
  };
  using D = InverseDynamics;
  using V = const Vector;
  def_torques(
      "torque", [](D& d, V& q, V& qd, V& qdd, Vector& to) { d.torque(q, qd, qdd, to); }, "q"_a, "qd"_a,
      "qdd"_a);
  def_torques("gravity", [](D& d, V& q, Vector& to) { d.gravity(q, to); }, "q"_a);
  def_torques("bias", [](D& d, V& q, V& qd, Vector& to) { d.bias(q, qd, to); }, "q"_a, "qd"_a);
  def_torques("coriolis", [](D& d, V& q, V& qd, Vector& to) { d.coriolis(q, qd, to); }, "q"_a, "qd"_a);
  def_torques("friction", [](D& d, V& qd, Vector& to) { d.friction(qd, to); }, "qd"_a);
  dynamics
      .def(
          "__init__",
          [](InverseDynamics* self, const DynamicModel& model, const Vector& smoothing_speed) {
            new (self) InverseDynamics(model, {.smoothing_speed = smoothing_speed});
          },
          "model"_a, "smoothing_speed"_a)
      .def_prop_ro("size", &InverseDynamics::size)
      .def(
          "mass_matrix",
          [](InverseDynamics& self, const Vector& q) {
            Matrix out(self.size(), self.size());
            self.M(q, out);
            return out;
          },
          "q"_a);
}

}  // namespace

void bind_dynamics(nb::module_& m) {
  bind_base(m);
  bind_model(m);
}

}  // namespace rivid::python
