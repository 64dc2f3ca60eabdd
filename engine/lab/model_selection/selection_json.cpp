#include "engine/lab/model_selection/selection_json.h"

#include "base/input_error.h"

#include <cmath>
#include <limits>
#include <string>

namespace springdrive::model_selection {

namespace {

using Json = nlohmann::ordered_json;

Json number_json(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

double number_of(const Json &json) {
    return json.is_null() ? std::numeric_limits<double>::infinity() : json.get<double>();
}

Json error_json(const ModelError &error) {
    return {{"force_N", number_json(error.force_N)},
            {"direction_rad", number_json(error.direction_rad)}};
}

ModelError error_of(const Json &json) {
    return {number_of(json.at("force_N")), number_of(json.at("direction_rad"))};
}

Json axis_json(const ModelAxis &axis, const scene::ModelTolerance &tolerance) {
    Json candidates = Json::array();
    for (const Candidate &candidate : axis.candidates) {
        candidates.push_back({{"name", candidate.name},
                              {"cost_ns", candidate.cost.min_ns},
                              {"median_cost_ns", candidate.cost.median_ns},
                              {"greatest_cost_ns", candidate.cost.max_ns},
                              {"error", error_json(candidate.error)},
                              {"verdict", verdict(candidate.error, tolerance)}});
    }
    Json cheaper = Json::array();
    for (const CheaperTrial &trial : axis.cheaper) {
        cheaper.push_back({{"name", axis.candidates[trial.candidate].name},
                           {"error", error_json(trial.error)},
                           {"verdict", verdict(trial.error, tolerance)}});
    }
    return {{"name", axis.name},
            {"candidates", candidates},
            {"chosen", axis.candidates[axis.chosen].name},
            {"cheaper_tried", cheaper}};
}

std::size_t index_of(const ModelAxis &axis, const std::string &name) {
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        if (axis.candidates[i].name == name) {
            return i;
        }
    }
    throw InputError("model choice: '" + name + "' is not one of its " + axis.name + " candidates");
}

ModelAxis axis_of(const Json &json) {
    ModelAxis axis;
    axis.name = json.at("name").get<std::string>();
    for (const Json &candidate : json.at("candidates")) {
        axis.candidates.push_back(
            {candidate.at("name").get<std::string>(),
             {candidate.at("cost_ns").get<double>(), candidate.at("median_cost_ns").get<double>(),
              candidate.at("greatest_cost_ns").get<double>()},
             error_of(candidate.at("error"))});
    }
    axis.chosen = index_of(axis, json.at("chosen").get<std::string>());
    for (const Json &trial : json.at("cheaper_tried")) {
        axis.cheaper.push_back(
            {index_of(axis, trial.at("name").get<std::string>()), error_of(trial.at("error"))});
    }
    return axis;
}

ModelSelection read(const Json &json) {
    ModelSelection choice;
    const Json &tolerance = json.at("tolerance");
    choice.tolerance = {tolerance.at("force_N").get<double>(),
                        tolerance.at("direction_rad").get<double>(),
                        tolerance.at("bandwidth_hz").get<double>()};
    for (const Json &axis : json.at("axes")) {
        choice.axes.push_back(axis_of(axis));
    }
    if (choice.axes.size() != kModelAspects) {
        throw InputError("model choice: it has " + std::to_string(choice.axes.size()) +
                         " axes instead of " + std::to_string(kModelAspects));
    }
    choice.error = error_of(json.at("error"));
    choice.cost_ns = json.at("cost_ns").get<double>();
    choice.fullest_cost_ns = json.at("fullest_cost_ns").get<double>();
    choice.warnings = json.at("remarks").get<std::vector<std::string>>();
    return choice;
}

} // namespace

Json json_of(const ModelSelection &choice) {
    Json axes = Json::array();
    for (const ModelAxis &axis : choice.axes) {
        axes.push_back(axis_json(axis, choice.tolerance));
    }
    return {{"tolerance",
             {{"force_N", choice.tolerance.force_N},
              {"direction_rad", choice.tolerance.direction_rad},
              {"bandwidth_hz", choice.tolerance.bandwidth_hz}}},
            {"axes", axes},
            {"error", error_json(choice.error)},
            {"cost_ns", choice.cost_ns},
            {"fullest_cost_ns", choice.fullest_cost_ns},
            {"remarks", choice.warnings}};
}

ModelSelection model_selection_of(const Json &json) {
    try {
        ModelSelection choice = read(json);
        static_cast<void>(model_of(choice)); // rejects unknown names
        return choice;
    } catch (const Json::exception &error) {
        throw InputError(std::string("model choice: cannot be read: ") + error.what());
    }
}

} // namespace springdrive::model_selection
