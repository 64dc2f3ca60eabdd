// Loads scenes in the background, so that neither window nor servo has to wait.
#pragma once

#include "base/background.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/load_progress.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::session {

/// A scene ready for display and touch.
struct LoadedScene {
    scene::Scene scene;
    contact::HapticSurface surface;
    std::string sha256; ///< of the scene's file
    std::optional<model_selection::ModelSelection>
        choice{}; ///< of the scene's model, if one was chosen
};

/// Loads a glTF file and prepares its surface. Any thread.
/// @throw InputError as `load_gltf` does.
/// @throw Cancelled soon after `progress` was cancelled
[[nodiscard]] std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                                      const device::Workspace &workspace,
                                                      scene::LoadProgress &progress);

/// For use by one thread. The destructor cancels loading and waits until it has ended, at most a
/// second.
class SceneLoader {
public:
    /// A final step for a loaded scene, also in the background. It must own all that it uses; if it
    /// fails, the scene is not shown.
    using Finish = std::function<void(LoadedScene &, scene::LoadProgress &, BackgroundTalk &)>;

    explicit SceneLoader(device::Workspace workspace) : workspace_(std::move(workspace)) {}
    ~SceneLoader() { progress_->give_up(); }
    SceneLoader(const SceneLoader &) = delete;
    SceneLoader &operator=(const SceneLoader &) = delete;

    /// Scenes requested from now on are fitted into this workspace.
    void set_workspace(const device::Workspace &workspace) { workspace_ = workspace; }

    /// Loads this scene next; of several requests while loading, the last one counts.
    void request(const std::filesystem::path &file, const Finish &finish);

    /// The scene, once, when it is ready. If loading failed, `error` holds the reason from then on.
    [[nodiscard]] std::unique_ptr<LoadedScene> take();

    [[nodiscard]] bool is_loading() const { return loading_.is_busy(); }
    [[nodiscard]] std::string progress() const { return progress_->text(); }
    [[nodiscard]] const std::string &error() const { return error_; }

private:
    struct Request {
        std::filesystem::path file;
        Finish finish;
    };

    device::Workspace workspace_;
    std::shared_ptr<scene::LoadProgress> progress_ = std::make_shared<scene::LoadProgress>();
    std::optional<Request> next_; ///< requested while another was loading
    std::string error_;
    Background<std::unique_ptr<LoadedScene>> loading_; ///< last member, so that it is joined first
};

} // namespace springdrive::session
