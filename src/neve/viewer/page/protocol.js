// What the server says to the page.
// Made from src/neve/viewer/protocol by `python -m neve.viewer.protocol.document`; do not edit it by hand.

/** Greatest number of a position or a value in a state; a particle with three of them has no position. */
export const MOST = 65535;

/** Bytes of a particle in a state. */
export const PARTICLE_BYTES = 8;

/**
 * Whether it plays, and how fast.
 * @typedef {object} PlayerState
 * @property {boolean} playing
 * @property {number} speed simulated seconds in a second, at most
 * @property {number} frames frames to seek in; 0 for a live run
 * @property {boolean} recording
 * @property {number} recorded frames of the recording
 * @property {string} undo what can be taken back, in words, or empty
 * @property {string} redo what can be done again, in words, or empty
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
 * Flakes in the air: the constants of their law, neve.render.falling, which the page computes, too.
 * @typedef {object} Falling
 * @property {number} count flakes of a cube of air, which is repeated without end
 * @property {number} edge of the cube [m]
 * @property {number} around how far from the camera flakes are, in distances to its target
 * @property {[number, number, number]} velocity on average [m/s]
 * @property {[number, number]} pace least speed and range of speeds over the average
 * @property {number} radius on average [m]
 * @property {[number, number]} spread least radius and range of radii over the average
 * @property {number} sway how far a flake swings aside [m]
 * @property {number} period of a swing along x, on average [s]
 * @property {number} second swings along y over those along x
 * @property {number[]} numbers numbers of the random numbers of place, pace, phase and radius
 * @property {number} open how long the shutter is open [s]
 * @property {number} least radius of the image of a flake that is drawn smaller than it is [px]
 * @property {number} faintest share of a pixel below which a flake is not drawn
 * @property {number} nearest distance from the camera [m]
 * @property {[number, number, number]} light
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
 * @property {boolean} [pulled] hangs on a joint, or is part of a robot: is pulled, not moved
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
 * @property {string} caption what is to be said of the scene, lest anyone is misled; empty: nothing
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Falling | null} falling null: no flakes are in the air
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
 * @property {any} [now] what the run goes on with until then, where that differs from value
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
 * A shape that can be added.
 * @typedef {object} Addable
 * @property {string} shape "mesh:rock", "terrain:alps.tif"
 * @property {[number, number, number]} half half of the edges of the box that stands on its place [m]; zeros if endless
 */

/**
 * A control of a motor or a robot.
 * @typedef {object} RobotControl
 * @property {string} name
 * @property {number} low
 * @property {number} high
 * @property {number} value
 */

/**
 * All that a page needs beside the states; sent again when it changes.
 * @typedef {object} SceneMessage
 * @property {string} name
 * @property {string} about
 * @property {string} caption what is to be said of the scene, lest anyone is misled; empty: nothing
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Falling | null} falling null: no flakes are in the air
 * @property {Solid[]} solids
 * @property {Mode[]} modes
 * @property {"scene"} kind
 * @property {number} number counts the changes
 * @property {boolean} live
 * @property {number} duration run.duration [s]
 * @property {PlayerState} player
 * @property {Section[]} panel
 * @property {Record<string, string>} presets scenes that can be opened, and what they show
 * @property {RobotControl[]} controls of motors and robots
 * @property {Record<string, Addable[]>} addable list of the scene -> shapes that can be added to it
 */

/**
 * The player's state has changed.
 * @typedef {object} PlayerMessage
 * @property {boolean} playing
 * @property {number} speed simulated seconds in a second, at most
 * @property {number} frames frames to seek in; 0 for a live run
 * @property {boolean} recording
 * @property {number} recorded frames of the recording
 * @property {string} undo what can be taken back, in words, or empty
 * @property {string} redo what can be done again, in words, or empty
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
 * Something that a user should know, and no fault.
 * @typedef {object} NoteMessage
 * @property {"note"} kind
 * @property {string} sentence
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
 * A figure that can be plotted.
 * @typedef {object} FigureColumn
 * @property {string} name
 * @property {string} unit
 */

/**
 * Figures over time: rows from number `first` on; from 0 on, all.
 * @typedef {object} FiguresMessage
 * @property {"figures"} kind
 * @property {number} first
 * @property {FigureColumn[]} columns
 * @property {((number | null)[])[]} rows number of the frame, then a value for each column
 */

/**
 * A scene or a run that can be opened.
 * @typedef {object} LibraryEntry
 * @property {string} name
 * @property {"scene" | "run"} kind
 */

/**
 * What lies in the served folders.
 * @typedef {object} LibraryMessage
 * @property {"library"} kind
 * @property {LibraryEntry[]} entries
 */

/**
 * A mesh or a height map that this page has dropped is there, and can be added.
 * @typedef {object} DroppedMessage
 * @property {"dropped"} kind
 * @property {Addable} what
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
 * @property {boolean} log the value is spaced by powers between the limits
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
 * @property {string} caption what is to be said of the scene, lest anyone is misled; empty: nothing
 * @property {number} fps
 * @property {number} dx [m]
 * @property {number} spacing of particles in snow at rest [m]
 * @property {number} cell size of a cell of the film's density grid [m]
 * @property {Camera} camera
 * @property {Light} light
 * @property {Falling | null} falling null: no flakes are in the air
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
 * @typedef {SceneMessage | PlayerMessage | RefusedMessage | NoteMessage | ProgressMessage | FileMessage | FiguresMessage | LibraryMessage | DroppedMessage} Message
 */
