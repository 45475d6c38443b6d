#!/usr/bin/perl
# The daemon's own life: settings, restart, SIGTERM, logs; and whom it answers (Host, Origin).
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use POSIX ();
use Test::More;
use Vt;

my $cloud = sphere_ply(4000);
my $long = 'points=4000&iterations=10000';

# Settings.
for my $case (
    [['--queue', '0'], qr/--queue is "0", want a whole number from 1 to 100000/],
    [['--queue=1.5'], qr/--queue is "1.5"/], [['--queue'], qr/--queue needs a value/],
    [['--body-limit', '1Q'], qr/--body-limit is "1Q", want bytes/],
    [['--drain-timeout', '-1'], qr/--drain-timeout is "-1", want seconds from 0 to 3600/],
    [['--log-level', 'loud'], qr/--log-level is "loud", want one of debug info warn error off/],
    [['--listen', 'localhost'], qr/--listen is "localhost", want HOST:PORT/],
    [['--listen', '127.0.0.1:70000'], qr/port from 0 to 65535/],
    [['--listen', '0.0.0.0:0'], qr/open to other machines.*--no-auth/],
    [['--listen', '[::]:0'], qr/open to other machines/],
    [['--store', 'mysql:x', '--listen', '127.0.0.1:0'], qr/sqlite:/, 1],
    [['--public-url', 'cloud.example'], qr/--public-url is "cloud\.example", want http:/],
    [['--public-url', 'ftp://cloud.example'], qr/want http:/], [['--public-url', 'https://'], qr/want http:/],
    [['--public-url', 'https://a b/'], qr/want http:/], [['--public-url', 'https://a/?x'], qr/want http:/],
    [['--cors-origin', '*'], qr/--cors-origin holds "\*", want a list of origins/],
    [['--cors-origin', 'https://a.example, https://b.example/'], qr{holds "https://b\.example/"}],
    [['--cors-origin', 'a.example'], qr/holds "a\.example"/],
    [['--he=1'], qr/--he is ambiguous, want --header-timeout or --heartbeat/], [['-x'], qr/no option -x; see voronoid serve --help/],
    [['--strea=0'], qr/--streams is "0"/], [['--jobs', '0x1'], qr/--jobs is "0x1", want/], [['--', '--jobs=1'], qr/no setting "--jobs=1"/],
    [['--colour=red'], qr/no option --colour; see/], [['--port=80'], qr/no option --port; the address is --listen HOST:PORT/], [['red'], qr/no setting "red"/], [['--lisen', 'x'], qr/no option --lisen; did you mean --listen\?/],
) {
    my ($arguments, $message, $wanted) = (@$case, 2);
    my ($status, $text) = Vt::run('--data', tempdir(CLEANUP => 1), @$arguments);
    my $name = join ' ', @$arguments;
    is $status, $wanted, "$name: exit status $wanted";
    like $text, $message, "$name: a message with value and range";
    is scalar(split /\n/, $text), 1, "$name: of one line";
}
{
    local $ENV{VORONOID_QUEUE} = 'many';
    my ($status, $text) = Vt::run('--data', tempdir(CLEANUP => 1));
    is $status, 2, 'a wrong value in the environment is refused too';
    like $text, qr/--queue is "many"/, 'and named';
    local $ENV{VORONOID_LISTEN} = '127.0.0.1:0';
    my $daemon = Vt->start(queue => 3);
    is $daemon->get('/livez')->{status}, 200, 'a flag wins over the environment';
    is $daemon->stop, 0, 'it ends with 0';
}
my ($status, $routes, $printed) = Vt::run('--print-routes');
like $printed, qr{^POST /v1/resample submit 200 }m, '--print-routes prints the routes';

my ($helped, undef, $help) = Vt::run('--help');
is $helped, 0, '--help is no mistake';
for my $entry (split /^  (?=--)/m, $help =~ s/\A.*?^Options:\n//msr =~ s/^  -h, --help.*//msr) {
    my ($flag) = $entry =~ /\A(--[a-z-]+)/ or next;
    like $entry, qr/\A--[a-z-]+(?: [A-Z]+(?::[A-Z]+)?| (?:sqlite|dir):PATH)?\n/, "$flag: its value has a name";
    my $variable = 'VORONOID_' . uc(substr $flag, 2) =~ tr/-/_/r;
    like $entry, qr/\(env: $variable\)\n*\z/, "$flag: $variable is named";
}

# One store, one daemon.
my $daemon = Vt->start(jobs => 1);
($status, my $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$daemon->{dir}/data");
is $status, 75, 'a second daemon on the same store ends with 75';
is scalar(() = $text =~ /\b$daemon->{pid}\b/g), 1, 'and names the first, once';

# Threads: the cores that the process may use, not those that there are.
SKIP: {
    my ($cpu) = (`taskset -pc $$ 2>/dev/null` // '') =~ /: (\d+)/;
    skip 'taskset: not on this machine', 1 unless defined $cpu;
    my $dir = tempdir(CLEANUP => 1);
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        open STDERR, '>', "$dir/log";
        exec 'taskset', '-c', $cpu, $ENV{VORONOID} // 'build/release/voronoid', 'serve', '--listen',
            '127.0.0.1:0', '--data', "$dir/data" or POSIX::_exit(127);
    }
    my $said = wait_until(sub { Vt::slurp("$dir/log") =~ /"msg":"listening".*"threads":(\d+)/ && $1 });
    is $said, 1, 'on one core it has one thread';
    kill 'TERM', $pid;
    waitpid $pid, 0;
}

# Restart.
my $done = $daemon->submit('points=100&iterations=3', $cloud);
$daemon->finish($done);
my $bytes = $daemon->get("/v1/jobs/$done/results/cloud")->{content};
my $reference = $daemon->post('/v1/resample?points=300&iterations=300&delta=0.0001', $cloud)->{content};
my $busy = $daemon->submit($long, $cloud);
my $waiting = $daemon->submit('points=300&iterations=300&delta=0.0001', $cloud);
wait_until(sub { $daemon->status($busy) eq 'running' });
is $daemon->stop('KILL'), 'signal 9', 'a daemon is killed while a job runs';
{
    my $other = Vt->start;
    ($status, $text) = Vt::run('--listen', $other->{address}, '--data', "$daemon->{dir}/data");
    is $status, 1, 'a daemon whose address is taken ends with 1';
    like $text, qr/cannot listen on 127\.0\.0\.1 port $other->{port}/, 'and names it';
    unlike $text, qr/"job started"/, 'and starts no job';
    is $other->stop, 0, 'the one that has the address does not mind';
}
$daemon = Vt->start(jobs => 1, dir => $daemon->{dir});
is $daemon->get("/v1/jobs/$done/results/cloud")->{content}, $bytes, 'results survive';
like $daemon->status($busy), qr/^(accepted|running)$/, 'the running job runs again';
wait_until(sub { $daemon->status($busy) eq 'running' });
is json($daemon->get("/v1/jobs/$busy"))->{voronoid}{attempt}, 2, 'as its second attempt';
my $first = $daemon->events("/v1/jobs/$busy/events", headers => { 'Last-Event-ID' => '1.7' })->next_event;
is $first->{event}, 'replaced', 'who followed the first attempt is told';
is $daemon->status($waiting), 'accepted', 'the waiting job still waits';
$daemon->request('DELETE', "/v1/jobs/$busy");
is $daemon->finish($waiting)->{status}, 'successful', 'and has its turn';
is $daemon->get("/v1/jobs/$waiting/results/cloud")->{content}, $reference,
    'with the bytes that a run without the crash yields';
is $daemon->stop, 0, 'it ends with 0';

# SIGTERM: running jobs end, callers get their answers, streams end, others are refused.
$daemon = Vt->start(jobs => 2, 'drain-timeout' => 3600);
# Both jobs would run for long: they are stopped once the daemon that drains has been asked everything.
my $socket = $daemon->connect;
$socket->print("POST /v1/resample?$long HTTP/1.1\r\nHost: localhost\r\nContent-Length: "
        . length($cloud) . "\r\n\r\n$cloud");
$socket->flush;
my $job = $daemon->submit($long, $cloud);
my @both;
wait_until(sub { @both = map { $_->{jobID} } @{ json($daemon->get('/v1/jobs?status=running'))->{jobs} }; @both == 2 });

my $stream = $daemon->events("/v1/jobs/$job/events", headers => { Accept => 'text/event-stream' });
$stream->next_event;
kill 'TERM', $daemon->{pid};
my $unready = wait_until(sub { my $a = $daemon->get('/readyz'); $a->{status} == 503 ? $a : undef });
is_problem($unready, 503, 'draining', 'SIGTERM makes the daemon un-ready');
# The daemon says so before it drains (--drain-delay): what comes in between is accepted, and waits for the next start.
my $refused = wait_until(sub { my $a = $daemon->post('/v1/resample?points=5', $cloud, Prefer => 'respond-async');
    $a->{status} == 201 ? undef : $a });
is_problem($refused, 503, 'draining', 'new jobs are refused');
is $daemon->get('/livez')->{status}, 200, 'it still lives';
is $daemon->request('POST', "/v1/jobs/$_/stop")->{status}, 202, 'a running job can be stopped' for @both;
my $last;
while (my $block = $stream->next_block) { $last = $block }
is $last->{retry}, 1000, 'a stream ends with retry: 1000';
ok $stream->{whole}, 'in good order';
my $answer = Vt::read_all($socket);
like $answer, qr{\AHTTP/1\.1 200 .*^element vertex 4000\n}ms, 'a caller who waits gets the result';
is Vt::reap(delete $daemon->{pid}), 0, 'the daemon ends with 0 by itself';
$daemon = Vt->start(dir => $daemon->{dir}, 'drain-timeout' => 0);
is $daemon->status($job), 'successful', 'the job ended while draining';
$job = $daemon->submit($long, $cloud);
wait_until(sub { $daemon->status($job) eq 'running' });
is $daemon->stop, 0, 'with no time to drain it ends too';
{ # a daemon that is ended so leaves its threads as they are, which ThreadSanitizer would take for a leak
    local $ENV{TSAN_OPTIONS} = join ':', $ENV{TSAN_OPTIONS} // (), 'report_thread_leaks=0';
    $daemon = Vt->start(dir => $daemon->{dir}, 'drain-timeout' => 3600);
}
like $daemon->status($job), qr/^(accepted|running)$/, 'its running job was put back';
wait_until(sub { $daemon->status($job) eq 'running' });
kill 'TERM', $daemon->{pid};
wait_until(sub { $daemon->get('/readyz')->{status} == 503 });
is $daemon->stop('TERM'), 1, 'a second SIGTERM ends it, for whose job there was an hour';

# Host and Origin.
$daemon = Vt->start('cors-origin' => 'https://a.example,https://b.example:8443',
    'public-url' => 'https://cloud.example/base/', 'no-auth' => 1);
sub with { my ($method, $path, %headers) = @_;
    my $lines = join '', map { "$_: $headers{$_}\r\n" } sort keys %headers;
    my $raw = $daemon->raw("$method $path HTTP/1.1\r\n${lines}Connection: close\r\n\r\n");
    my ($code) = $raw =~ m{\AHTTP/1\.1 (\d+)};
    return ($code, head_of($raw), $raw);
}
for my $host ('localhost', "localhost:$daemon->{port}", '127.0.0.1', '[::1]:80', 'LOCALHOST',
    'cloud.example') {
    is +(with('GET', '/livez', Host => $host))[0], 200, "Host $host is answered";
}
for my $host ('evil.example', 'localhost.evil.example', "evil.example:$daemon->{port}", '127.0.0.2',
    'cloud.example.evil') {
    my ($code, undef, $raw) = with('GET', '/v1/jobs', Host => $host);
    is $code, 403, "Host $host is refused";
    like $raw, qr{"type":"https://cloud\.example/base/problems/forbidden"}, "Host $host: as forbidden";
}
my ($code, $head) = with('GET', '/v1/jobs', Host => 'localhost', Origin => 'https://a.example');
is $code, 200, 'an allowed origin may read';
like $head, qr{^Access-Control-Allow-Origin: https://a\.example\r$}m, 'and its page may see it';
like $head, qr{^Access-Control-Expose-Headers: Location, ETag, Retry-After}m, 'with its headers';
like $head, qr{^Vary: Origin\r$}m, 'and caches know';
unlike $head, qr{Allow-Credentials}, 'but no credentials';
is +(with('GET', '/v1/jobs', Host => 'localhost', Origin => $_->[0]))[0], $_->[1], "Origin $_->[0]"
    for ['https://cloud.example', 200], ['https:', 403], ['https:/', 403], ['https://cloud.exampl', 403];
($code, $head) = with('OPTIONS', '/v1/resample', Host => 'localhost', Origin => 'https://b.example:8443',
    'Access-Control-Request-Method' => 'POST', 'Access-Control-Request-Headers' => 'prefer');
is $code, 204, 'a preflight is answered';
like $head, qr{^Access-Control-Allow-Methods: POST, OPTIONS\r$}m, 'with the methods';
like $head, qr{^Access-Control-Allow-Headers: .*\b$_\b}m, "and the header $_"
    for qw(Authorization Content-Type Idempotency-Key If-None-Match Last-Event-ID Prefer Range traceparent);
for my $origin ('https://evil.example', 'null', 'https://a.example.evil', 'http://a.example',
    'https://b.example') {
    ($code, $head) = with('GET', '/v1/jobs', Host => 'localhost', Origin => $origin);
    unlike $head, qr{Access-Control-Allow-Origin}, "Origin $origin sees nothing";
    is +(with('POST', '/v1/resample?points=5', Host => 'localhost', Origin => $origin,
                'Content-Length' => 0))[0], 403, "Origin $origin may not submit";
    is +(with('DELETE', '/v1/jobs/x', Host => 'localhost', Origin => $origin))[0], 403,
        "Origin $origin may not dismiss";
}
is +(with('POST', '/v1/resample?points=5', Host => 'localhost', Origin => 'http://localhost',
            'Content-Length' => 0))[0], 422, "the daemon's own origin may submit";
my $named = $daemon->post('/v1/resample?points=5&iterations=1', $cloud, Prefer => 'respond-async');
like $named->{headers}{location}, qr{\Ahttps://cloud\.example/base/v1/jobs/}, '--public-url makes the links';
my $named_id = json($named)->{jobID};
$daemon->finish($named_id);

# Logs.
my @lines = eval { $daemon->log_lines };
is $@, '', 'every log line is JSON';
ok !(grep { !defined $_->{ts} || !defined $_->{level} || !defined $_->{msg} } @lines),
    'with time, level and message';
my ($request) = grep { $_->{msg} eq 'request' && $_->{status} == 204 } @lines;
is_deeply [grep { !defined $request->{$_} } qw(request_id method route status dur_s bytes)], [],
    'a request is logged with all that is asked of it';
is_deeply [map { $_->{job} } grep { ($_->{request_id} // '') eq $named->{headers}{'x-request-id'} } @lines],
    [$named_id], 'the request that made a job is logged with its name';
ok((grep { $_->{msg} eq 'request' && ($_->{job} // '') eq $named_id && $_->{method} eq 'GET' } @lines),
    'so is one that asks for it');
ok !(grep { $_->{msg} eq 'request' && $_->{route} eq '/v1/jobs' && defined $_->{job} } @lines),
    'and no other';
$daemon->raw("GET /\x1b[31mred HTTP/1.1\r\nHost: localhost\r\nX-Request-Id: \xff\xfe\r\nConnection: close\r\n\r\n");
$daemon->raw("GET /a%0d%0aInjected:%20x HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
@lines = eval { $daemon->log_lines };
is $@, '', 'also after what a stranger sent';
unlike $daemon->log_text, qr/[^\n\x20-\x7e]/, 'and none has raw control bytes';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
