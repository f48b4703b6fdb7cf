/** Engine, tyres and wind, made in the page from oscillators and noise; silent until somebody asks for it. */
import type { CarState } from "../car/state";

/** What is heard: levels 0..1 and frequencies [Hz]. */
export interface Mix {
  readonly engine: number;
  readonly pitch: number;
  readonly tyres: number;
  readonly crunch: number;
  readonly wind: number;
  readonly gust: number;
}

/** Ignitions of the engine at full revs [Hz]: four strokes, four cylinders, 6,000 a minute. */
const IGNITIONS = 200;

/** How a car sounds; `cockpit`: heard from inside. */
export function mixOf(
  state: Pick<CarState, "speed" | "revs" | "enginePower" | "wheels">,
  cockpit: boolean,
): Mix {
  const speed = Math.abs(state.speed);
  const pull = Math.min(1, Math.max(0, state.enginePower) / 90e3);
  const on = state.wheels.filter(({ grounded }) => grounded);
  const slip = on.reduce((most, wheel) => Math.max(most, Math.abs(wheel.slip)), 0);
  const deep = on.reduce((sum, wheel) => sum + Math.max(0, wheel.sinkage), 0) / Math.max(1, on.length);
  const rolling = on.length > 0 ? Math.min(1, speed / 18) : 0;
  return {
    engine: (0.16 + 0.5 * pull) * (cockpit ? 1 : 0.8),
    pitch: IGNITIONS * Math.max(0.12, state.revs),
    tyres: Math.min(1, rolling * (0.35 + 2.2 * Math.min(deep, 0.25)) + Math.min(0.5, 0.06 * slip)),
    // Deep snow takes the high sounds away.
    crunch: 420 + 1500 * Math.exp(-8 * deep) + 60 * slip,
    wind: Math.min(1, (speed / 38) ** 2) * (cockpit ? 0.5 : 1),
    gust: 250 + 22 * speed,
  };
}

interface Voices {
  readonly context: BaseAudioContext;
  readonly low: OscillatorNode;
  readonly high: OscillatorNode;
  readonly tone: BiquadFilterNode;
  readonly engine: GainNode;
  readonly tyres: GainNode;
  readonly crunch: BiquadFilterNode;
  readonly wind: GainNode;
  readonly gust: BiquadFilterNode;
}

/** Make the voices of a context; they sound as `tune` says. */
export function voices(context: BaseAudioContext): Voices {
  const out = new DynamicsCompressorNode(context);
  out.connect(context.destination);
  const tone = new BiquadFilterNode(context, { type: "lowpass", Q: 0.9 });
  const engine = new GainNode(context, { gain: 0 });
  tone.connect(engine).connect(out);
  const [low, high] = (["sawtooth", "square"] as const).map((type) => {
    const one = new OscillatorNode(context, { type });
    one.connect(new GainNode(context, { gain: type === "square" ? 0.25 : 0.6 })).connect(tone);
    one.start();
    return one;
  }) as [OscillatorNode, OscillatorNode];
  const hiss = (type: BiquadFilterType, Q: number) => {
    const source = new AudioBufferSourceNode(context, { buffer: noise(context), loop: true });
    const filter = new BiquadFilterNode(context, { type, Q });
    const level = new GainNode(context, { gain: 0 });
    source.connect(filter).connect(level).connect(out);
    source.start();
    return [filter, level] as const;
  };
  const [crunch, tyres] = hiss("bandpass", 0.6);
  const [gust, wind] = hiss("lowpass", 0.4);
  return { context, low, high, tone, engine, tyres, crunch, wind, gust };
}

/** Let the voices go to a mix, smoothly; `at once` for a beginning. */
export function tune(v: Voices, mix: Mix, atOnce = false): void {
  const go = (parameter: AudioParam, value: number) => {
    if (atOnce) parameter.value = value;
    else parameter.setTargetAtTime(value, v.context.currentTime, 0.06);
  };
  go(v.low.frequency, 0.5 * mix.pitch);
  go(v.high.frequency, mix.pitch);
  go(v.tone.frequency, 160 + 3 * mix.pitch + 900 * mix.engine);
  go(v.engine.gain, 0.4 * mix.engine);
  go(v.tyres.gain, 0.5 * mix.tyres);
  go(v.crunch.frequency, mix.crunch);
  go(v.wind.gain, 0.6 * mix.wind);
  go(v.gust.frequency, mix.gust);
}

/** Two seconds of white noise, the same each time. */
function noise(context: BaseAudioContext): AudioBuffer {
  const buffer = new AudioBuffer({ length: 2 * context.sampleRate, sampleRate: context.sampleRate });
  let state = 12345;
  const data = buffer.getChannelData(0);
  for (let k = 0; k < data.length; k++) {
    state = (state * 48271) % 2147483647; // Lehmer 1951
    data[k] = (2 * state) / 2147483647 - 1;
  }
  return buffer;
}

/** The sound of the page: off at first, since browsers ask for a gesture and people for silence. */
export class Sound {
  private context: AudioContext | null = null;
  private made: Voices | null = null;

  get on(): boolean {
    return this.context?.state === "running";
  }

  /** Switch it on or off. */
  async toggle(): Promise<boolean> {
    if (this.on) await this.context!.suspend();
    else {
      this.context ??= new AudioContext();
      this.made ??= voices(this.context);
      await this.context.resume();
    }
    return this.on;
  }

  update(mix: Mix): void {
    if (this.on) tune(this.made!, mix);
  }
}
