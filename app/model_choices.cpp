#include "app/model_choices.h"

#include "base/input_error.h"
#include "engine/model_choice/choice_cache.h"

#include <unistd.h>

#include <cmath>
#include <exception>
#include <iostream>
#include <utility>

namespace springdrive {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

/// Writes over its own line again and again, and leaves none behind.
class TerminalLine {
public:
    ~TerminalLine() {
        if (is_terminal_) {
            std::cerr << "\r\033[K" << std::flush;
        }
    }
    void show(const std::string &text) const {
        if (is_terminal_) {
            std::cerr << "\r\033[Kspringdrive: measuring models: " << text << std::flush;
        }
    }

private:
    bool is_terminal_ = isatty(STDERR_FILENO) == 1;
};

} // namespace

Scene without_looks(const Scene &scene) {
    Scene bare;
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

std::optional<ModelChoice> remembered_choice(const ModelQuestion &question,
                                             const std::string &device_text) {
    return read_model_choice(model_cache_folder(),
                             model_choice_key(question, device_text, SPRINGDRIVE_VERSION));
}

ModelChoice measured_choice(const ModelQuestion &question, const std::string &device_text,
                            const ModelProgress &progress) {
    ModelChoice choice = choose_scene_model(question, progress);
    write_model_choice(model_cache_folder(),
                       model_choice_key(question, device_text, SPRINGDRIVE_VERSION), choice);
    return choice;
}

ModelChoice known_choice(const ModelQuestion &question, const std::string &device_text,
                         const ModelProgress &progress) {
    if (std::optional<ModelChoice> choice = remembered_choice(question, device_text)) {
        return *std::move(choice);
    }
    return measured_choice(question, device_text, progress);
}

ModelChoice choice_with_progress(const ModelQuestion &question, const std::string &device_text,
                                 bool fresh) {
    const TerminalLine line;
    const ModelProgress show = [&line](const std::string &what, double share) {
        line.show(text_of(what, share));
    };
    return fresh ? measured_choice(question, device_text, show)
                 : known_choice(question, device_text, show);
}

void ModelMeasurement::begin(const ModelQuestion &question, const std::string &device_text) {
    forget();
    error_.clear();
    measuring_.start([question, device_text,
                      scene = without_looks(*question.scene)](BackgroundTalk &talk) {
        ModelQuestion own = question;
        own.scene = &scene;
        return measured_choice(own, device_text, [&talk](const std::string &what, double share) {
            talk.tell(what, share);
        });
    });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<ModelChoice> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive
