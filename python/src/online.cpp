#include "binding.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/robot_state.hpp"

namespace rivid::python {

namespace {

using Values = Eigen::Ref<const Vector>;
using Body = Eigen::Matrix<double, inertial_count, 1>;

constexpr const char* finishes = "Does all work that waits for the next ticks.";

void bind_online_model(nb::module_& m) {
  nb::class_<OnlineModel>(m, "OnlineModel", "An identified robot with its uncertainty.")
      .def(
          "__init__",
          [](OnlineModel* self, const Robot& robot, const Vector& chi, const Matrix& C_chi,
             const Vector& sigma_rho, const Vector& velocity_threshold) {
            new (self) OnlineModel{robot, base_parameters(robot), chi, C_chi, sigma_rho, velocity_threshold};
          },
          "robot"_a, "chi"_a, "C_chi"_a, "sigma_rho"_a, "velocity_threshold"_a)
      .def_static(
          "of_result",
          [](const std::filesystem::path& path, bool force) {
            return read_online_model(path, {.parameters = {}, .force = force});
          },
          "path"_a, "force"_a = false)
      .def_static("of_fit", &online_model, "robot"_a, "result"_a)
      .def_prop_ro("size", [](const OnlineModel& self) { return self.robot.size(); })
      .def("model", [](const OnlineModel& self) { return DynamicModel(self.robot, self.base, self.chi); });
}

void bind_payload_estimator(nb::module_& m) {
  using Payload = OnlinePayload<double>;
  nb::class_<Payload>(m, "OnlinePayload", "A payload in the flange frame.")
      .def_ro("mass", &Payload::mass, "[kg]")
      .def_ro("mass_sigma", &Payload::mass_sigma, "Its standard deviation, all that is not known included.")
      .def_prop_ro("mass_half_width", &Payload::mass_half_width, "Half of the 95 % interval of the mass.")
      .def_ro("com", &Payload::com, "Centre of mass [m].")
      .def_ro("com_sigma", &Payload::com_sigma)
      .def_ro("inertia", &Payload::inertia, "About the centre of mass, axes of the flange [kg·m²].")
      .def_ro("inertia_sigma", &Payload::inertia_sigma, "Of Ixx Iyy Izz.")
      .def_ro("held", &Payload::held, "Whether there is a payload.")
      .def_ro("body", &Payload::body, "Whether the inertia is determined; else the payload is a point.")
      .def_ro("good", &Payload::good, "Whether the numbers are good enough to send to a controller.");
  using Estimator = PayloadEstimator<double>;
  nb::class_<Estimator>(m, "PayloadEstimator")
      .def(
          "__init__",
          [](Estimator* self, const OnlineModel& model, double f_m, bool torque_held,
             const Eigen::Matrix3d& R, const Eigen::Vector3d& p, double gain_sigma) {
            new (self) Estimator(
                model,
                {.rows = {.f_m = f_m, .torque_held = torque_held}, .R = R, .p = p, .gain_sigma = gain_sigma});
          },
          "model"_a, "f_m"_a, "torque_held"_a, "R"_a, "p"_a, "gain_sigma"_a)
      .def(
          "update", [](Estimator& self, Values q, Values tau) { return self.update(q, tau); }, "q"_a, "tau"_a)
      .def("pause", &Estimator::pause,
           "Instead of ``update``, for a tick that says nothing of the payload: while something touches the "
           "robot.")
      .def("finish", &Estimator::finish, finishes)
      .def_prop_ro(
          "payload", [](const Estimator& self) { return self.payload(); }, "The payload as of now.")
      .def_prop_ro(
          "inertial", [](const Estimator& self) { return Body(self.inertial()); },
          "The payload as ten parameters XX … M of the last link, for ``set_payload`` of the other "
          "estimators.")
      .def_prop_ro("suspicion", &Estimator::suspicion,
                   "The test of a change over its threshold: above 1 there is one.")
      .def_prop_ro(
          "change_tick", [](const Estimator& self) { return self.change().tick; },
          "Tick at which the last change was found, counted from the first; 0 where there was none.");
}

void bind_contact_observer(nb::module_& m) {
  using Observer = ContactObserver<double>;
  nb::class_<Observer>(m, "ContactObserver")
      .def(
          "__init__",
          [](Observer* self, const DynamicModel& model, double f_m, double bandwidth, double alarms_per_hour,
             const Vector& smoothing_speed) {
            new (self) Observer(model, {.f_m = f_m,
                                        .bandwidth = bandwidth,
                                        .alarms_per_hour = alarms_per_hour,
                                        .smoothing_speed = smoothing_speed});
          },
          "model"_a, "f_m"_a, "bandwidth"_a, "alarms_per_hour"_a, "smoothing_speed"_a)
      .def(
          "update",
          [](Observer& self, Values q, Values qd, Values tau, bool learn) {
            return self.update(q, qd, tau, learn ? Observer::Mode::learn : Observer::Mode::observe);
          },
          "q"_a, "qd"_a, "tau"_a, "learn"_a = false)
      .def_prop_ro(
          "residual", [](const Observer& self) { return Vector(self.residual()); },
          "External torques behind a low-pass [N·m | N].")
      .def_prop_ro(
          "relative", [](const Observer& self) { return Vector(self.relative()); },
          "The residual over its threshold: above 1 in magnitude is a contact.")
      .def_prop_ro(
          "thresholds",
          [](const Observer& self) {
            return Vector(Vector::NullaryExpr(self.size(), [&](Index j) { return self.threshold(j); }));
          },
          "Infinite before anything was learned [N·m | N].")
      .def_prop_ro("link", &Observer::link, "The link that is touched, counted from 0; −1 without a contact.")
      .def("force", &Observer::force, "link"_a, "point"_a)
      .def("set_payload", &Observer::set_payload, "body"_a)
      .def("reset", &Observer::reset, "Begins anew; thresholds stay.")
      .def("forget", &Observer::forget, "Begins anew without thresholds.");
}

void bind_friction_monitor(nb::module_& m) {
  using Monitor = FrictionMonitor<double>;
  const auto of_each = [](auto function) {
    return [function](const Monitor& self) {
      return Vector(Vector::NullaryExpr(std::ssize(self.coefficients()),
                                        [&](Index i) { return std::invoke(function, self, i); }));
    };
  };
  nb::class_<Monitor>(m, "FrictionMonitor")
      .def(
          "__init__",
          [](Monitor* self, const OnlineModel& model, double f_m, bool torque_held, double forgetting) {
            new (self)
                Monitor(model, {.rows = {.f_m = f_m, .torque_held = torque_held}, .forgetting = forgetting});
          },
          "model"_a, "f_m"_a, "torque_held"_a, "forgetting"_a)
      .def(
          "update", [](Monitor& self, Values q, Values tau) { self.update(q, tau); }, "q"_a, "tau"_a)
      .def("set_payload", &Monitor::set_payload, "body"_a)
      .def("finish", &Monitor::finish, finishes)
      .def_prop_ro(
          "names",
          [](const Monitor& self) {
            std::vector<std::string> out;
            for (const Monitor::Coefficient& each : self.coefficients()) {
              out.push_back(each.name());
            }
            return out;
          },
          "\"Fv1\", … in the order of the arrays.")
      .def_prop_ro("values", of_each(&Monitor::value), "Coefficients now [SI, joint side].")
      .def_prop_ro("sigmas", of_each(&Monitor::sigma), "Their standard deviations.")
      .def_prop_ro("drifts", of_each(&Monitor::drift),
                   "Distances from the identified values, in standard deviations of both.")
      .def_prop_ro(
          "torque_errors",
          [](const Monitor& self) {
            return Vector(Vector::NullaryExpr(self.joints(), [&](Index j) { return self.torque_error(j); }));
          },
          "Root mean square of the torque error of each joint that the drift means for the motion of late "
          "[N·m | N].");
}

void bind_recursive_identifier(nb::module_& m) {
  using Identifier = RecursiveIdentifier<double>;
  nb::class_<Identifier>(m, "RecursiveIdentifier")
      .def(
          "__init__",
          [](Identifier* self, const OnlineModel& model, double f_m, bool torque_held, double forgetting,
             bool prior) {
            new (self) Identifier(
                model,
                {.rows = {.f_m = f_m, .torque_held = torque_held}, .forgetting = forgetting, .prior = prior});
          },
          "model"_a, "f_m"_a, "torque_held"_a, "forgetting"_a, "prior"_a)
      .def(
          "update", [](Identifier& self, Values q, Values tau) { self.update(q, tau); }, "q"_a, "tau"_a)
      .def("finish", &Identifier::finish, finishes)
      .def_prop_ro(
          "chi", [](Identifier& self) { return Vector(self.chi()); },
          "The base parameters; not numbers while some are not determined.")
      .def_prop_ro(
          "sigma",
          [](Identifier& self) {
            return Vector(Vector::NullaryExpr(self.size(), [&](Index i) { return self.sigma(i); }));
          },
          "Their standard deviations for errors that are independent.")
      .def_prop_ro("rows", &Identifier::rows, "Rows so far.");
}

void bind_robot_state(nb::module_& m) {
  nb::class_<TickQuality>(m, "TickQuality", "What was wrong with a tick.")
      .def_ro("lost", &TickQuality::lost, "Ticks before it that did not come, or were not taken.")
      .def_ro("gap", &TickQuality::gap, "They were too many to be filled in: everything begins anew.")
      .def_ro("not_finite", &TickQuality::not_finite, "It has no number, or one that no robot has.")
      .def_ro("repeated", &TickQuality::repeated, "It is the one before once more.")
      .def_ro("late", &TickQuality::late, "Its time is that of no tick.")
      .def_ro("glitch", &TickQuality::glitch, "The tick before it was a glitch, and was replaced.")
      .def_prop_ro("good", &TickQuality::good);
  using State = RobotState<double>;
  nb::class_<State>(m, "RobotState")
      .def(
          "__init__",
          [](State* self, const OnlineModel& model, double f_m, bool torque_held, const Eigen::Matrix3d& R,
             const Eigen::Vector3d& p, double gain_sigma, double learn) {
            RobotStateOptions options;
            options.payload.rows = {.f_m = f_m, .torque_held = torque_held};
            options.payload.R = R;
            options.payload.p = p;
            options.payload.gain_sigma = gain_sigma;
            options.learn = learn;
            new (self) State(model, DynamicModel(model.robot, model.base, model.chi), options);
          },
          "model"_a, "f_m"_a, "torque_held"_a, "R"_a, "p"_a, "gain_sigma"_a, "learn"_a)
      .def(
          "update", [](State& self, double t, Values q, Values tau) { return self.update(t, q, tau); }, "t"_a,
          "q"_a, "tau"_a)
      .def_prop_ro(
          "payload", [](const State& self) { return self.payload(); }, "The payload as of now.")
      .def_prop_ro("payload_changes", &State::payload_changes,
                   "Changes of the payload that were found or said.")
      .def_prop_ro("contact", &State::contact, "Whether something touches the robot.")
      .def_prop_ro("collision", &State::collision, "Whether something hits it.")
      .def_prop_ro(
          "link", [](const State& self) { return self.observer().link(); },
          "The link that is touched, counted from 0, or a later one; −1 without a contact.")
      .def_prop_ro(
          "external", [](const State& self) { return Vector(self.observer().residual()); },
          "External torques behind a low-pass [N·m | N].")
      .def_prop_ro(
          "friction_gained", [](const State& self) { return Vector(self.friction_gained()); },
          "Torques that friction has gained since the identification [N·m | N].")
      .def_prop_ro("left_to_learn", &State::left_to_learn, "Time for which thresholds are still learned [s].")
      .def("payload_changed", &State::payload_changed, "The controller says: the payload has changed.")
      .def(
          "payload_known",
          [](State& self, double mass, const Eigen::Vector3d& com, double mass_sigma, double com_sigma) {
            return self.payload_known(mass, com, mass_sigma, com_sigma);
          },
          "mass"_a, "com"_a, "mass_sigma"_a, "com_sigma"_a)
      .def("gripper", &State::gripper, nb::kw_only(), "open"_a,
           "The gripper opens or closes. What was held while it was open is held again when it opens.")
      .def(
          "feedforward",
          [](State& self, Values q, Values qd, Values qdd) { return Vector(self.feedforward(q, qd, qdd)); },
          "q"_a, "qd"_a, "qdd"_a);
}

}  // namespace

void bind_online(nb::module_& m) {
  bind_online_model(m);
  bind_payload_estimator(m);
  bind_contact_observer(m);
  bind_friction_monitor(m);
  bind_recursive_identifier(m);
  bind_robot_state(m);
}

}  // namespace rivid::python
