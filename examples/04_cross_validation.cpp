#include <iostream>

#include "rivid/rivid.hpp"

// Trained on one log, judged on another: ordinary and weighted least squares side by side.
int main(int argc, char** argv) {
  const std::filesystem::path data = argc > 1 ? argv[1] : "data/scara";
  rivid::Robot robot = rivid::read_urdf(data / "scara.urdf");
  for (rivid::Joint& joint : robot.joints) {
    joint.friction = rivid::Friction::coulomb;
    joint.rotor_inertia = false;
  }
  const rivid::Log training = rivid::read_csv(data / "scara_s2.csv");
  const rivid::Log unseen = rivid::read_csv(data / "scara_validation.csv");

  const rivid::SignalOptions signal = {.torque_held = true,  // v acts from t_k to t_{k+1}
                                       .cutoff_hz = 20.0,
                                       .decimation = {20}};
  const rivid::Identification ols =
      rivid::identify(robot, training, {.method = rivid::Ols{}, .signal = signal});
  const rivid::Identification wls =
      rivid::identify(robot, training, {.method = rivid::Wls{}, .signal = signal});

  std::cout << "parameter: OLS (sigma), WLS (sigma)\n";
  for (std::size_t i = 0; i < ols.parameters.size(); ++i) {
    const rivid::ParameterEstimate& o = ols.parameters[i];
    const rivid::ParameterEstimate& w = wls.parameters[i];
    std::cout << o.name << ": " << o.value << " (" << o.sigma << "), " << w.value << " (" << w.sigma << ") "
              << o.unit << '\n';
  }

  bool carried_over = true;
  for (const rivid::Identification* fitted : {&ols, &wls}) {
    const rivid::Fit& on_training = fitted->fit;
    const rivid::Fit on_unseen = rivid::validate(robot, *fitted, unseen).fit;
    std::cout << fitted->title << ": relative error " << on_training.relative_error << " on its own log, "
              << on_unseen.relative_error << " on the other\n";
    for (std::size_t j = 0; j < on_unseen.joints.size(); ++j) {
      std::cout << "  " << on_unseen.joints[j].name << ": " << on_training.joints[j].relative_error << ", "
                << on_unseen.joints[j].relative_error << '\n';
      // A model that only fits its own log would err several times as much on another.
      carried_over =
          carried_over && on_unseen.joints[j].relative_error < 2.0 * on_training.joints[j].relative_error;
    }
  }
  return carried_over ? 0 : 1;
}
