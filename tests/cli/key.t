#!/usr/bin/perl
# voronoid key, and a client that has one.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib $FindBin::Bin;
use Cli;
use IO::Socket::INET;
use Test::More;

my $folder = scratch();
delete @ENV{qw(VORONOID_KEY VORONOID_KEY_FILE)};
my $in = spew("$folder/in.ply", sphere(300));
my @quick = ('-n', 50, '--iterations', 2, '-q');

my ($code, $line, $key) = run(['key', 'render']);
is $code, 0, 'a key is made';
chomp $key;
like $key, qr/\Avor_[A-Za-z0-9_-]{32}\z/, 'of 192 bits, with a prefix that is known again';
is $line, 'render:submit,read:' . sha256_hex($key) . "\n", 'its line has its digest';
isnt +(run(['key', 'render']))[2], "$key\n", 'the next one is another';
my (undef, $bounded, $root) = run(['key', 'root', '--scopes', 'admin', '--quotas=jobs=3,rate=0.5']);
like $bounded, qr/\Aroot:admin:[0-9a-f]{64}:jobs=3,rate=0\.5\n\z/, 'scopes and quotas are in it';
for my $case (
    [[], qr/no name/], [['a', 'b'], qr/one operand too many/], [['a b'], qr/the name is "a b", want 1 to 64/],
    [['a', '--scopes', 'write'], qr/the scopes are "write", want one or more of read, submit and admin/],
    [['a', '--quotas', 'jobs=0'], qr/a quota is "jobs=0", want jobs=a whole number from 1/],
) {
    my ($arguments, $message) = @$case;
    my ($status, $stdout, $stderr) = run(['key', @$arguments]);
    is "$status|$stdout", '2|', "key @$arguments: makes none";
    like $stderr, $message, 'and says why';
}

# A daemon with these two.
spew("$folder/keys", $line . $bounded);
chmod 0600, "$folder/keys";
spew("$folder/key", "$key\n");
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--api-keys', "$folder/keys");
my @server = ('--server', $daemon->{url});
my ($status, $stdout, $stderr) = run(['resample', $in, @quick, '-fo', "$folder/none.ply", @server]);
is $status, 1, 'without a key nothing is done';
like $stderr, qr/The request needs a key: the request has no key; send one as/, 'and the answer is told';
($status, undef, $stderr) = run(['resample', $in, @quick, '-fo', "$folder/out.ply", @server, '--api-key-file', "$folder/key"]);
is "$status|$stderr", '0|', 'with that of a file it is';
($status, $stdout) = run(['jobs', '-q', @server], env => { VORONOID_KEY => $key });
is $status, 0, 'or of VORONOID_KEY';
like $stdout, qr/\A[-0-9a-f]{36}\n\z/, 'which sees its job';
($status, $stdout) = run(['jobs', '-q', @server], env => { VORONOID_KEY_FILE => "$folder/key", VORONOID_KEY => 'none' });
is $status, 0, 'the file wins over it';
is +(run(['health', @server]))[0], 0, 'health needs none';
for my $case (["\n", qr/is empty, want a key on its first line/], ["two words\n", qr/has no valid key, want at most 512 visible/],
    ['x' x 513, qr/has no valid key/]) {
    spew("$folder/bad", $case->[0]);
    ($status, undef, $stderr) = run(['jobs', @server, '--api-key-file', "$folder/bad"]);
    is $status, 2, 'what is no key is refused';
    like $stderr, $case->[1], 'with a reason';
    unlike $stderr, qr/two words|xxx/, 'and is not shown';
}
stop($daemon);

# A server that sends its client elsewhere does not get the key sent there.
my @ports = map { IO::Socket::INET->new(LocalAddr => '127.0.0.1', Listen => 5) or die "no port: $!" } 1, 2;
my $elsewhere = 'http://127.0.0.1:' . $ports[1]->sockport . '/v1/jobs/0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11';
my $client = fork // die "fork: $!";
if ($client == 0) {
    run(['resample', $in, @quick, '-fo', "$folder/x.ply", '--server', 'http://127.0.0.1:' . $ports[0]->sockport],
        env => { VORONOID_KEY => $key });
    POSIX::_exit(0);
}
like head_on($ports[0], "HTTP/1.1 201 Created\r\nLocation: $elsewhere\r\nContent-Length: 2\r\nConnection: close\r\n\r\n{}"),
    qr/^Authorization: Bearer \Q$key\E\r$/m, 'the key goes where the client was told';
my $head = head_on($ports[1], "HTTP/1.1 404 None\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
like $head, qr{\AGET /v1/jobs/}, 'the client follows the address of the job';
unlike $head, qr/Authorization|\Q$key\E/, 'without the key';
kill 'KILL', $client;
waitpid $client, 0;
done_testing;

# The head of the next request to a port, which gets an answer once its body is in.
sub head_on {
    my ($port, $answer) = @_;
    my $socket = $port->accept or die "accept: $!";
    my ($text, $head) = '';
    while ($text !~ /\r\n\r\n/) { $socket->sysread($text, 65536, length $text) or last }
    ($head) = $text =~ /\A(.*?\r\n)\r\n/s;
    my $left = ($head =~ /^Content-Length: (\d+)/mi ? $1 : 0) - (length($text) - length($head) - 2);
    while ($left > 0) { my $got = $socket->sysread(my $piece, 65536) or last; $left -= $got }
    $socket->print($answer);
    close $socket;
    return $head;
}
