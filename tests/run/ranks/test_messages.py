"""How long messages between ranks are."""

import numpy as np

from neve.domains.transport import Piece
from neve.ranks import transport


def test_long_messages_go_in_several(monkeypatch):
    """Each is short enough for an MPI that counts bytes in 31 bits; together they are the whole, in order."""
    assert transport.MOST <= 2**31 - 1
    size = 5 * 2**30 + 7
    pieces = list(transport._pieces(Piece(64, size)))
    assert max(piece.size for piece in pieces) <= transport.MOST
    assert [piece.at for piece in pieces] == (64 + np.cumsum([0, *(p.size for p in pieces[:-1])])).tolist()
    assert sum(piece.size for piece in pieces) == size
    monkeypatch.setattr(transport, "MOST", 10)
    numbers = np.arange(7, dtype=np.float64).reshape(7, 1)
    parts = list(transport._parts(numbers))
    assert [len(part) for part in parts] == [10, 10, 10, 10, 10, 6]
    np.testing.assert_array_equal(np.concatenate(parts).view(np.float64), numbers[:, 0])
    assert [len(part) for part in transport._parts(numbers[:0])] == [0], "an empty array is a message, too"
