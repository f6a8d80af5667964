#include "pinocchio_regressor.hpp"

#include <pinocchio/multibody.hpp>
// After the model.
#include <pinocchio/algorithm/regressor.hpp>
#include <string>

struct PinocchioRegressor::Impl {
  pinocchio::Model model;
  pinocchio::Data data;
};

PinocchioRegressor::PinocchioRegressor(const std::vector<Link>& links, const std::array<double, 3>& gravity)
    : impl_(std::make_unique<Impl>()) {
  pinocchio::Model& model = impl_->model;
  pinocchio::JointIndex parent = 0;
  for (std::size_t j = 0; j < links.size(); ++j) {
    const pinocchio::SE3 placement(Eigen::Matrix3d(Eigen::Matrix3d::Map(links[j].R.data())),
                                   Eigen::Vector3d(Eigen::Vector3d::Map(links[j].p.data())));
    const std::string name = "joint_" + std::to_string(j + 1);
    parent = links[j].revolute ? model.addJoint(parent, pinocchio::JointModelRZ(), placement, name)
                               : model.addJoint(parent, pinocchio::JointModelPZ(), placement, name);
  }
  model.gravity.linear() = Eigen::Vector3d::Map(gravity.data());
  impl_->data = pinocchio::Data(model);
}

PinocchioRegressor::~PinocchioRegressor() = default;

const double* PinocchioRegressor::operator()(const double* q, const double* qd, const double* qdd) {
  using Values = Eigen::Map<const Eigen::VectorXd>;
  const Eigen::Index n = impl_->model.nv;
  return pinocchio::computeJointTorqueRegressor(impl_->model, impl_->data, Values(q, n), Values(qd, n),
                                                Values(qdd, n))
      .data();
}
