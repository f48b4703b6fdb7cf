/** Pixels of the canvas per CSS pixel, so that slow machines keep up: fewer when frames take long, more when not. */
export class Sharpness {
  ratio: number;
  private readonly most: number;
  private slow = 0;
  private quick = 0;

  /** most: of the screen, no more than 2. */
  constructor(most: number) {
    this.most = Math.min(2, Math.max(0.5, most));
    this.ratio = this.most;
  }

  /**
   * Take in a frame of dt [s]; true if the ratio changed. Two seconds below 40 frames/s make it coarser by a quarter, ten
   * above 56 finer; a frame of more than half a second is no measure (a hidden tab, a new window).
   */
  take(dt: number): boolean {
    if (dt > 0.5) return false;
    this.slow = dt > 1 / 40 ? this.slow + dt : 0;
    this.quick = dt < 1 / 56 ? this.quick + dt : 0;
    const factor = this.slow > 2 ? 0.75 : this.quick > 10 ? 4 / 3 : 1;
    if (factor === 1) return false;
    this.slow = this.quick = 0;
    const before = this.ratio;
    this.ratio = Math.min(this.most, Math.max(0.5, this.ratio * factor));
    return this.ratio !== before;
  }
}
