// What the page says to the server: types alone.
// Made from src/neve/viewer/protocol by `python -m neve.viewer.protocol.document`; do not edit it by hand.

export {};

/**
 * Hold a page's camera: points [m], vertical angle [degrees], size of the picture [px].
 * @typedef {object} PageCamera
 * @property {[number, number, number]} position
 * @property {[number, number, number]} target
 * @property {[number, number, number]} [up]
 * @property {number} [fov]
 * @property {number} [width]
 * @property {number} [height]
 */

/**
 * Say that the state number `version` has been drawn.
 * @typedef {object} AcknowledgeCommand
 * @property {"acknowledge"} do
 * @property {number} version
 */

/**
 * Choose the colours of this page, with the values of the first and the last one, or found from the snow. `log` spaces the colours between them by powers.
 * @typedef {object} ColorModeCommand
 * @property {"color_mode"} do
 * @property {string} mode
 * @property {[number, number] | null} [limits]
 * @property {boolean} [log]
 */

/**
 * Play.
 * @typedef {object} PlayCommand
 * @property {"play"} do
 */

/**
 * Pause.
 * @typedef {object} PauseCommand
 * @property {"pause"} do
 */

/**
 * Play one frame, and pause.
 * @typedef {object} FrameCommand
 * @property {"frame"} do
 */

/**
 * Begin again; a live run, with all changes to the scene.
 * @typedef {object} RestartCommand
 * @property {"restart"} do
 */

/**
 * Set how many simulated seconds pass in one second at most.
 * @typedef {object} SpeedCommand
 * @property {"speed"} do
 * @property {number} factor
 */

/**
 * Show a frame of a recorded run: number `frame` of those that it has, or the one next to `time` [s].
 * @typedef {object} SeekCommand
 * @property {"seek"} do
 * @property {number} [frame]
 * @property {number | null} [time]
 */

/**
 * Tell the figures over time, now and from now on.
 * @typedef {object} PlotCommand
 * @property {"plot"} do
 */

/**
 * Tell which scenes and runs lie in the served folders.
 * @typedef {object} LibraryCommand
 * @property {"library"} do
 */

/**
 * Play another scene that comes with Neve, or a scene or run of the library.
 * @typedef {object} OpenCommand
 * @property {"open"} do
 * @property {string} scene
 */

/**
 * Bring a piece of a file that was dropped: from byte number `at`, of so many bytes; `data` in base64.
 * @typedef {object} PieceCommand
 * @property {"piece"} do
 * @property {string} name
 * @property {number} at
 * @property {number} of
 * @property {string} data
 */

/**
 * Change a value of the scene: `path` as in --set.
 * @typedef {object} SetCommand
 * @property {"set"} do
 * @property {string} path
 * @property {boolean | number | string | number[] | null} value
 */

/**
 * Add a body or snow of one `shape` at a point [m]; `kind` is a list of the scene.
 * @typedef {object} AddCommand
 * @property {"add"} do
 * @property {string} kind
 * @property {string} shape
 * @property {[number, number, number]} at
 */

/**
 * Add a table that is left out, or one more entry to a list of tables: "colliders.1.keyframes".
 * @typedef {object} EnlargeCommand
 * @property {"enlarge"} do
 * @property {string} path
 */

/**
 * Delete an entry of the scene, or a table in one: "colliders.1", "sources.0.variation".
 * @typedef {object} DeleteCommand
 * @property {"delete"} do
 * @property {string} name
 */

/**
 * Take back the last change of the scene.
 * @typedef {object} UndoCommand
 * @property {"undo"} do
 */

/**
 * Do again what was taken back last.
 * @typedef {object} RedoCommand
 * @property {"redo"} do
 */

/**
 * Put the solid `name` at a position [m] with a rotation vector [degrees]; `done` ends the drag.
 * @typedef {object} MoveCommand
 * @property {"move"} do
 * @property {string} name
 * @property {[number, number, number]} position
 * @property {[number, number, number] | null} [rotation]
 * @property {boolean} [done]
 */

/**
 * Throw a ball of snow from a point [m] along a direction, with a speed [m/s]; radius [m].
 * @typedef {object} ThrowCommand
 * @property {"throw"} do
 * @property {[number, number, number]} origin
 * @property {[number, number, number]} direction
 * @property {number} [speed]
 * @property {number} [radius]
 */

/**
 * Push or grab the snow within `radius` [m] of a point [m] that moves with a velocity [m/s].
 * @typedef {object} TouchCommand
 * @property {"touch"} do
 * @property {"push" | "grab"} tool
 * @property {[number, number, number]} point
 * @property {[number, number, number]} velocity
 * @property {number} radius
 * @property {boolean} [done]
 */

/**
 * Pull a body by a spring: from a point of its own frame [m] to a target [m]; `done` lets it go.
 * @typedef {object} PullCommand
 * @property {"pull"} do
 * @property {string} name
 * @property {[number, number, number]} grip
 * @property {[number, number, number]} target
 * @property {boolean} [done]
 */

/**
 * Hold the control `name` of a motor or robot at a value; without one, the scene has it again.
 * @typedef {object} DriveCommand
 * @property {"drive"} do
 * @property {string} name
 * @property {number | null} [value]
 */

/**
 * Begin or end the recording of a live run.
 * @typedef {object} RecordCommand
 * @property {"record"} do
 * @property {boolean} on
 */

/**
 * Draw a PNG with the page's camera.
 * @typedef {object} PictureCommand
 * @property {"picture"} do
 * @property {PageCamera} camera
 */

/**
 * Make a film of all frames of the run, or of the last recording, with the page's camera.
 * @typedef {object} FilmCommand
 * @property {"film"} do
 * @property {PageCamera} camera
 */

/**
 * Make a page that plays the run by itself.
 * @typedef {object} ReplayCommand
 * @property {"replay"} do
 */

/**
 * Write the scene as TOML; with `camera`, with the page's camera.
 * @typedef {object} SaveCommand
 * @property {"save"} do
 * @property {PageCamera | null} [camera]
 */

/**
 * What a page may ask for.
 * @typedef {AcknowledgeCommand | ColorModeCommand | PlayCommand | PauseCommand | FrameCommand | RestartCommand | SpeedCommand | SeekCommand | PlotCommand | LibraryCommand | OpenCommand | PieceCommand | SetCommand | AddCommand | EnlargeCommand | DeleteCommand | UndoCommand | RedoCommand | MoveCommand | ThrowCommand | TouchCommand | PullCommand | DriveCommand | RecordCommand | PictureCommand | FilmCommand | ReplayCommand | SaveCommand} Command
 */
