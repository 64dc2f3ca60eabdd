// The scene that is shown and touched, and its replacement while the servo is running. Scenes are
// loaded in the background, so that neither window nor servo has to wait.
//
//   request ──► SceneLoader, in the background ──► take_loaded ──► now()
//                                                    │ the previous one
//                                                    ▼
//                         release on its own thread ◄── kept until the servo no longer uses it
#pragma once

#include "base/background.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/// For use by one thread.
class Scenes {
public:
    /// @param first  not null
    Scenes(const device::Workspace &workspace, std::unique_ptr<LoadedScene> first);

    /// Loads in the background; on failure the current scene stays and `error` holds the reason. Of
    /// several requests while loading, the last one counts.
    void request(const std::filesystem::path &file, const SceneLoader::Finish &finish = {});

    /// Makes a loaded scene the current one, with a new number. Returns the previous scene, which
    /// stays valid until the servo no longer uses it; null if none was loaded.
    [[nodiscard]] const LoadedScene *take_loaded();

    /// Call when the servo uses the scene with this number: earlier ones are released.
    void note_in_use(std::uint32_t id);

    /// Scenes requested from now on are fitted into this workspace.
    void set_workspace(const device::Workspace &workspace) { loader_.set_workspace(workspace); }

    [[nodiscard]] LoadedScene &now() { return *now_; }
    [[nodiscard]] const LoadedScene &now() const { return *now_; }
    /// Number of the current scene: 1 for the first.
    [[nodiscard]] std::uint32_t id() const { return id_; }
    /// Number of previous scenes not yet released, as the servo may still use them.
    [[nodiscard]] std::size_t retired() const { return retired_.size(); }

    [[nodiscard]] bool is_loading() const { return loader_.is_loading(); }
    [[nodiscard]] std::string progress() const { return loader_.progress(); }
    [[nodiscard]] const std::string &error() const { return loader_.error(); }

private:
    BackgroundRelease<LoadedScene> release_;
    std::unique_ptr<LoadedScene> now_;
    std::uint32_t id_ = 1;
    std::vector<std::unique_ptr<LoadedScene>> retired_;
    SceneLoader loader_;
};

} // namespace springdrive::session
