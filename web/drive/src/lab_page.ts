import { rollWheel, sinkage } from "./lab";

declare global {
  interface Window {
    neveLab?: { rollWheel: typeof rollWheel; sinkage: typeof sinkage };
  }
}

window.neveLab = { rollWheel, sinkage };
