#if defined(STRICT) && WIDE == 1 && defined(TECSGEN)
typedef long long Wide;
#else
typedef short Wide;
#endif
