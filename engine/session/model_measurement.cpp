#include "engine/session/model_measurement.h"

#include <cmath>
#include <exception>
#include <utility>

namespace springdrive::session {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

} // namespace

scene::Scene without_looks(const scene::Scene &scene) {
    scene::Scene bare;
    bare.file = scene.file;
    bare.surface = scene.surface;
    bare.flat_surface = scene.flat_surface;
    bare.shapes = scene.shapes;
    bare.lower_m = scene.lower_m;
    bare.upper_m = scene.upper_m;
    bare.metres_per_unit = scene.metres_per_unit;
    bare.in_metres = scene.in_metres;
    bare.planar = scene.planar;
    bare.tolerance = scene.tolerance;
    return bare;
}

void ModelMeasurement::begin(std::shared_ptr<const model_selection::ModelChooser> chooser,
                             const model_selection::ModelQuestion &question,
                             const model_selection::ModelMemory &memory) {
    discard();
    error_.clear();
    measuring_.start([chooser = std::move(chooser), question, memory,
                      scene = without_looks(*question.scene)](BackgroundTalk &talk) {
        model_selection::ModelQuestion own = question;
        own.scene = &scene;
        return chooser->measured(own, memory, [&talk](const std::string &what, double share) {
            talk.report(what, share);
        });
    });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<model_selection::ModelSelection> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive::session
