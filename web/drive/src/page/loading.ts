import { element } from "./words";

/** The bar that tells how far the page has come; `show` lets the browser paint it before the work goes on. */
export class Loading {
  private readonly bar = element("loading") as HTMLProgressElement;

  /** `share` 0..1 is done, and now comes `what`. */
  async show(share: number, what: string): Promise<void> {
    this.bar.value = Math.max(this.bar.value, share);
    this.bar.textContent = this.bar.ariaValueText = what;
    const place = element("message");
    place.textContent = what;
    place.hidden = false;
    // A hidden tab gets no frames: the timer goes on there.
    await new Promise<void>((next) => {
      requestAnimationFrame(() => setTimeout(next));
      setTimeout(next, 100);
    });
  }

  done(): void {
    this.bar.hidden = true;
  }
}
