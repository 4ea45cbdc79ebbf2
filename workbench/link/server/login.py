"""Whether a client may come in, and as what."""

from workbench.link.authentication import is_same, login_proof, session_key
from workbench.link.backplane import Role
from workbench.link.operations import Login
from workbench.link.server.terms import Terms


class BadLoginError(Exception):
    """A login that proves nothing."""


def check_login(login: Login, terms: Terms, nonce: str) -> tuple[Role, bytes | None]:
    """Return what a client may do, and the key of its frames' proofs, None where none are asked.

    Args:
        login: what it says.
        terms: of the server.
        nonce: that it was given.

    Raises:
        BadLoginError: if it does not know the token.
    """
    if terms.tokens is None:
        return (Role.VIEW if login.role is Role.VIEW else terms.best_role), None
    if login.role is None or not login.nonce or not login.proof:
        raise BadLoginError("login needs role, nonce and proof: this server has tokens")
    token = terms.tokens.of(login.role)
    if not is_same(login.proof, login_proof(token, login.role, nonce, login.nonce)):
        raise BadLoginError(f"the proof is not that of the token of role {login.role.value}")
    role = login.role if terms.allow_commands else Role.VIEW
    return role, session_key(token, nonce, login.nonce)
