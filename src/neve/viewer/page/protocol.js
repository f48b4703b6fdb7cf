// What the page and the server say to each other.
// Made from src/neve/viewer/protocol by `python -m neve.viewer.protocol.document`; do not edit it by hand.

/** Greatest number of a position or a value in a state; a particle with three of them has no position. */
export const MOST = 65535;

/** Bytes of a particle in a state. */
export const PARTICLE_BYTES = 8;

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
 * Choose the colour mode of this page.
 * @typedef {object} ColorModeCommand
 * @property {"color_mode"} do
 * @property {string} mode
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
 * Show frame number `frame` of a recorded run.
 * @typedef {object} SeekCommand
 * @property {"seek"} do
 * @property {number} frame
 */

/**
 * Play another scene that comes with Neve.
 * @typedef {object} OpenCommand
 * @property {"open"} do
 * @property {string} scene
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
 * @typedef {AcknowledgeCommand | ColorModeCommand | PlayCommand | PauseCommand | FrameCommand | RestartCommand | SpeedCommand | SeekCommand | OpenCommand | SetCommand | AddCommand | EnlargeCommand | DeleteCommand | MoveCommand | ThrowCommand | TouchCommand | RecordCommand | PictureCommand | FilmCommand | ReplayCommand | SaveCommand} Command
 */

/**
 * Whether it plays, and how fast.
 * @typedef {object} PlayerState
 * @property {boolean} playing
 * @property {number} speed simulated seconds in a second, at most
 * @property {number} frames frames to seek in; 0 for a live run
 * @property {boolean} recording
 * @property {number} recorded frames of the recording
 */

/**
 * The camera of a scene.
 * @typedef {object} Camera
 * @property {[number, number, number]} position [m]
 * @property {[number, number, number]} target [m]
 * @property {[number, number, number]} up
 * @property {number} fov vertical angle [degrees]
 */

/**
 * Sun and sky in the units of the film.
 * @typedef {object} Light
 * @property {[number, number, number]} sun unit vector towards the sun
 * @property {[number, number, number]} sun_color
 * @property {[number, number, number]} sky_color
 */

/**
 * Triangles, in base64.
 * @typedef {object} Mesh
 * @property {string} vertices corners [m], float32, little endian
 * @property {string} faces three corners a triangle, uint32, little endian
 */

/**
 * A solid as it is drawn; its position and rotation come with each state.
 * @typedef {object} Solid
 * @property {string} name its place in the scene: "colliders.1"
 * @property {string} shape
 * @property {[number, number, number]} half half of its size along each axis [m]
 * @property {[number, number, number]} color
 * @property {boolean} visible
 * @property {boolean} ground drawn as ground
 * @property {Mesh} [mesh]
 */

/**
 * One line of a legend of names.
 * @typedef {object} LegendName
 * @property {number | null} value whose colour stands before it; null: none does
 * @property {string} text
 */

/**
 * A colour mode.
 * @typedef {object} Mode
 * @property {string} name
 * @property {string} label
 * @property {string} unit
 * @property {boolean} classes the values are names, not amounts
 * @property {[number, number, number][]} stops colours from the least to the greatest value, 0 to 255
 * @property {LegendName[]} names the legend of a mode whose values are names
 */

/**
 * What is drawn beside the particles, and how large a particle is.
 * @typedef {object} Drawn
 * @property {string} name
 * @property {string} about
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Solid[]} solids
 * @property {Mode[]} modes
 */

/**
 * How a value is edited.
 * @typedef {object} Control
 * @property {"number" | "choice" | "switch" | "vector" | "list" | "text"} control
 * @property {any[]} [choices]
 * @property {boolean} [optional]
 * @property {number} [count] numbers of a vector
 * @property {boolean} [whole] only whole numbers
 * @property {number} [gt]
 * @property {number} [ge]
 * @property {number} [lt]
 * @property {number} [le]
 */

/**
 * A field of a section of the panel.
 * @typedef {object} Field
 * @property {"number" | "choice" | "switch" | "vector" | "list" | "text"} control
 * @property {any[]} [choices]
 * @property {boolean} [optional]
 * @property {number} [count] numbers of a vector
 * @property {boolean} [whole] only whole numbers
 * @property {number} [gt]
 * @property {number} [ge]
 * @property {number} [lt]
 * @property {number} [le]
 * @property {string} path as in --set: "snow.xi"
 * @property {string} name
 * @property {string} text meaning
 * @property {string} unit
 * @property {string} allowed what it may hold, in words
 * @property {string} source where its default comes from
 * @property {any} default
 * @property {any} value
 * @property {boolean} live a change acts at once; else when the scene begins anew
 */

/**
 * A section of the panel: a table of the scene.
 * @typedef {object} Section
 * @property {string} path
 * @property {string} title
 * @property {string} text meaning
 * @property {string} parent path of the section that it lies in, or empty
 * @property {"" | "add" | "delete"} can what can be done with the whole section
 * @property {Field[]} fields
 */

/**
 * All that a page needs beside the states; sent again when it changes.
 * @typedef {object} SceneMessage
 * @property {string} name
 * @property {string} about
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Solid[]} solids
 * @property {Mode[]} modes
 * @property {"scene"} kind
 * @property {number} number counts the changes
 * @property {boolean} live
 * @property {PlayerState} player
 * @property {Section[]} panel
 * @property {Record<string, string>} presets scenes that can be opened, and what they show
 * @property {Record<string, string[]>} addable list of the scene -> shapes that can be added to it
 */

/**
 * The player's state has changed.
 * @typedef {object} PlayerMessage
 * @property {boolean} playing
 * @property {number} speed simulated seconds in a second, at most
 * @property {number} frames frames to seek in; 0 for a live run
 * @property {boolean} recording
 * @property {number} recorded frames of the recording
 * @property {"player"} kind
 */

/**
 * A command was refused, and why.
 * @typedef {object} RefusedMessage
 * @property {"refused"} kind
 * @property {string} sentence
 * @property {string} path of the value that was refused, or empty
 */

/**
 * An export goes on.
 * @typedef {object} ProgressMessage
 * @property {"progress"} kind
 * @property {string} what
 * @property {number} done
 * @property {number} of
 */

/**
 * An export is finished.
 * @typedef {object} FileMessage
 * @property {"file"} kind
 * @property {string} name
 * @property {string} url
 * @property {string} place path on the server's machine
 * @property {number} bytes
 */

/**
 * Figures of a run; a recorded one has particles alone.
 * @typedef {object} Facts
 * @property {number} [particles]
 * @property {number} [steps]
 * @property {number} [dt] mean time step [s]
 * @property {string} [bound] what bounds the time step
 * @property {number} [rejected] steps that were rejected and tried again
 * @property {number} [pace] simulated seconds in a second
 * @property {Record<string, number[]>} [keyed] what keyframes change, as it is now
 * @property {Record<string, number>} [stages] share of the time that each stage takes, in the solver's order
 */

/**
 * The head of a state, which comes as bytes; state.py has the layout.
 * @typedef {object} StateHead
 * @property {"state"} kind
 * @property {number} version counts the states
 * @property {number} n particles
 * @property {[number, number, number]} low position of q = 0 [m]
 * @property {[number, number, number]} step position = low + step q [m]
 * @property {string} mode colour mode that the values belong to
 * @property {[number, number]} limits values that get the first and the last colour
 * @property {boolean} classes the values are names
 * @property {number} time simulated [s]
 * @property {number} frame
 * @property {number} scene number of the scene message that it belongs to
 * @property {number[][]} poses position [m] and rotation, row by row, of each solid: twelve numbers
 * @property {Facts} facts
 */

/**
 * The head of a replay; exports/replay.py says how the positions are packed.
 * @typedef {object} ReplayHead
 * @property {string} name
 * @property {string} about
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Solid[]} solids
 * @property {Mode[]} modes
 * @property {number} n particles
 * @property {[number, number, number]} low position of q = 0 [m]
 * @property {[number, number, number]} step position = low + step q [m]
 * @property {number[]} keys frames whose positions are held
 * @property {number} frames
 * @property {number[]} times of each frame [s]
 * @property {number[][][]} poses of each frame: as in a state
 */

/**
 * What the server sends as text.
 * @typedef {SceneMessage | PlayerMessage | RefusedMessage | ProgressMessage | FileMessage} Message
 */
